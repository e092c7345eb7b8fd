"""The option of commands that simulate walks: how much of the world is shown (docs/simulators.md)."""

from typing import Annotated

import typer

Honest = Annotated[
    bool | None,
    typer.Option("--honest/--simple", show_default=False,
                 help="Drives with friction, play, a sagging supply; or plain. Else as the robot file says."),
]  # fmt: skip
