"""The `caramelo` command: gathers host/commands. Only here errors become a line on stderr and an exit code."""

import errno
import importlib
import signal
import sys
from collections.abc import Sequence
from functools import cache
from typing import Annotated

import typer
from typer.core import TyperGroup

from . import commands
from .boards.core import use_core
from .util.console import end_output, say, write_error
from .util.errors import INTERRUPTED, NOT_ACHIEVED, WRONG_USE, UserError
from .util.extras import missing_library
from .util.leave import heard_signals

HELP = """Control software of four-legged walking robots, and simulators to try it in.

Start here:

[bold]caramelo walk[/] walks Caramelo over flat ground in the simulator and prints the figures.

[bold]caramelo walk --terrain step --height 0.02 --out out/demo[/] climbs 2 cm and writes an animation.

[bold]caramelo robots show caramelo[/] prints a robot's data; [bold]caramelo robots check my.toml[/] checks your file.
"""
EPILOG = (
    "COMMAND --help explains each command, with examples. With --json a command prints exactly one JSON object. "
    "Exit codes: 0 done, 1 not achieved, 2 wrong use or bad input, 130 stopped by Ctrl-C."
)


@cache
def build_command() -> TyperGroup:
    """Return the `caramelo` command with the commands of every file in host/commands; it is built once."""
    app = typer.Typer(
        name="caramelo",
        help=HELP,
        epilog=EPILOG,
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(invoke_without_command=True)(_top)
    for name, panel in commands.PANELS.items():
        module = importlib.import_module(f"{commands.__name__}.{name}")
        if hasattr(module, "GROUP"):
            app.add_typer(module.GROUP, name=name, rich_help_panel=panel)
        else:
            app.command(name, rich_help_panel=panel)(getattr(module, name))
    command = typer.main.get_command(app)
    assert isinstance(command, TyperGroup)
    return command


def _print_version(wanted: bool) -> None:
    if wanted:
        from .util.version import software_version

        say(software_version())
        raise typer.Exit


def _top(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; errors are printed as one line on stderr."""
    with heard_signals() as heard:
        code = _run(arguments)
    if code == INTERRUPTED and heard:
        write_error(f"stopped by {signal.Signals(heard[0]).name}")
        return 128 + heard[0]
    if code == INTERRUPTED:
        write_error("stopped by Ctrl-C")
    trouble = end_output()
    if trouble:
        write_error(trouble)
        return NOT_ACHIEVED
    return code


def _run(arguments: Sequence[str] | None) -> int:
    try:
        use_core()
        code = build_command()(args=arguments, prog_name="caramelo", standalone_mode=False)
    except UserError as error:
        write_error(str(error))
        return error.exit_code
    except ModuleNotFoundError as error:
        missing = missing_library(error)
        if missing is None:
            raise
        write_error(str(missing))
        return missing.exit_code
    except typer.Abort:
        write_error("stopped: no answer")
        return WRONG_USE
    except typer.TyperException as error:
        write_error(_wrong_use(error))
        return WRONG_USE
    except OSError as error:
        write_error(end_output() or _refusal(error))
        return NOT_ACHIEVED
    except KeyboardInterrupt:
        return INTERRUPTED
    return code if isinstance(code, int) else 0


def _refusal(error: OSError) -> str:
    """Return a line for an error of the system that no command explains itself, such as a full disk."""
    if error.filename is None and error.errno == errno.ENOSPC:  # whatever writes a file names it
        return f"the output can't be written: {error.strerror}"
    what = "" if error.filename is None else f"{error.filename}: "
    return f"{what}the system refused: {error.strerror or error}"


def _wrong_use(error: typer.TyperException) -> str:
    """Return what is wrong with a command line, and the command that prints its help."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "caramelo"
    return f"{error.format_message().rstrip('.')} (see {command} --help)"


if __name__ == "__main__":
    sys.exit(main())
