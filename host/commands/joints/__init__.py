"""`caramelo joints`: finds, watches, arms, numbers and sets up the brushless joints on CAN, and simulates them."""

from collections.abc import Callable

import typer

from . import board, commission, compare, dbc, drive, figures, load, look, page, params, simulate


def _group() -> typer.Typer:
    group = typer.Typer(
        help="Find, watch, arm, number and set up the CAN joints, or simulate them.", no_args_is_help=True
    )
    commands: dict[str, Callable[..., int]] = {
        "scan": look.scan,
        "status": look.status,
        "monitor": look.monitor,
        "page": page.page,
        "arm": drive.arm,
        "disarm": drive.disarm,
        "clear": drive.clear,
        "set-id": board.set_id,
        "commission": commission.commission,
        "busload": load.busload,
        "dbc": dbc.dbc,
        "compare": compare.compare,
        "figures": figures.figures,
        "sim": simulate.sim,
    }
    for name, command in commands.items():
        group.command(name)(command)
    kept = typer.Typer(help="Read, write, save and compare the joints' parameters.", no_args_is_help=True)
    parts: dict[str, Callable[..., int]] = {
        "get": params.get,
        "set": params.set_,
        "save": params.save,
        "restore": params.restore,
        "diff": params.diff,
    }
    for name, command in parts.items():
        kept.command(name)(command)
    group.add_typer(kept, name="params")
    return group


GROUP = _group()
