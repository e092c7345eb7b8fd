"""Options that several commands have."""

from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
RobotName = Annotated[str, typer.Option("--robot", help="A robot's name, or a file ending in .toml.")]
# In how many processes trials run, or by which cluster (docs/cluster.md)
Jobs = Annotated[int, typer.Option(min=1, max=256, help="Processes of this computer to run trials in.")]
ClusterAt = Annotated[
    str, typer.Option("--cluster", metavar="ADDRESS", help="Run trials on this dask cluster: tcp://HOST:PORT.")
]
# How much of the world is simulated (docs/simulators.md)
Honest = Annotated[
    bool | None,
    typer.Option("--honest/--simple", show_default=False,
                 help="Drives with friction, play, a sagging supply; or plain. Else as the robot file says."),
]  # fmt: skip
