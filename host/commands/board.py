"""`caramelo board`: shows what a board is and what it noted, resets it, opens its prompt."""

import sys
from typing import Annotated

import typer

from ..util.console import say, screen, write_json
from ..util.errors import UserError
from ._options import Json

Port = Annotated[str, typer.Option("--port", help="Serial port of the board.")]

GROUP = typer.Typer(help="Look at a board, reset it, use its prompt.", no_args_is_help=True)


@GROUP.command()
def info(port: Port, as_json: Json = False) -> int:
    """Print what a board is and which firmware it holds. The command stops its application and starts it again.

    It also checks that a freshly installed MicroPython answers.

    Example: caramelo board info --port /dev/ttyACM0
    """
    from ..boards.flash.inspect import describe

    facts = describe(port)
    if as_json:
        write_json(facts)
        return 0
    console = screen()
    console.soft_wrap = True
    for name, value in facts.items():
        console.print(f"{name.replace('_', ' '):12} {_shown(value)}")
    return 0


@GROUP.command()
def logs(port: Port, as_json: Json = False) -> int:
    """Print the board's notes on failed starts, newest last.

    Example: caramelo board logs --port /dev/ttyACM0
    """
    from ..boards.flash.inspect import read_log

    lines = read_log(port)
    if as_json:
        write_json({"port": port, "lines": lines})
    else:
        say("\n".join(lines) if lines else f"{port}: nothing noted")
    return 0


@GROUP.command()
def reset(port: Port) -> int:
    """Reset a board, so that its firmware starts.

    Example: caramelo board reset --port /dev/ttyACM0
    """
    from ..boards.flash.inspect import restart

    restart(port)
    say(f"{port}: reset")
    return 0


@GROUP.command()
def shell(port: Port) -> int:
    """Open the board's prompt: Ctrl-C stops the running program, Ctrl-D restarts, Ctrl-] leaves.

    Example: caramelo board shell --port /dev/ttyACM0
    """
    from ..boards.flash.shell import run_shell

    if not sys.stdin.isatty():
        raise UserError("board shell: needs a terminal; in scripts use mpremote")
    run_shell(port)
    return 0


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {item}" for key, item in value.items())
    return "-" if value is None or value == "" else str(value)
