"""The options of commands that run trials: in how many processes, or by which cluster (docs/cluster.md)."""

from typing import Annotated

import typer

Jobs = Annotated[int, typer.Option(min=1, max=256, help="Processes of this computer to run trials in.")]
ClusterAt = Annotated[
    str, typer.Option("--cluster", metavar="ADDRESS", help="Run trials on this dask cluster: tcp://HOST:PORT.")
]
