"""`caramelo joints`: finds, watches, arms, numbers and sets up the brushless joints on CAN, and simulates them."""

from collections.abc import Callable

import typer

from . import bus, commission, drive, figures, look, page, params, simulate

COMMANDS: tuple[Callable[..., int], ...] = (
    look.scan, look.status, look.monitor, page.page, drive.arm, drive.disarm, drive.clear, drive.set_id,
    commission.commission, bus.busload, bus.dbc, figures.compare, figures.figures, simulate.sim,
)  # fmt: skip

GROUP = typer.Typer(help="Find, watch, arm, number and set up the CAN joints, or simulate them.", no_args_is_help=True)
for command in COMMANDS:
    GROUP.command()(command)
GROUP.add_typer(params.GROUP, name="params")
