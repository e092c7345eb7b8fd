"""Options that several commands have."""

from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
RobotName = Annotated[str, typer.Option("--robot", help="A robot's name, or a file ending in .toml.")]
# Where trials and fits run: in this many processes, or on a cluster (docs/cluster.md)
Jobs = Annotated[int, typer.Option(min=1, max=256, help="Compute in this many processes.")]
ClusterAt = Annotated[
    str, typer.Option("--cluster", metavar="ADDRESS", help="Compute on this dask cluster: tcp://HOST:PORT.")
]
# How much of the world is simulated (docs/simulators.md)
Honest = Annotated[
    bool | None,
    typer.Option("--honest/--simple", show_default=False,
                 help="Drives with friction, play and a sagging supply, or plain ones (default: the robot file's)."),
]  # fmt: skip
