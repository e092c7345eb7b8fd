"""`caramelo core`: the control core as machine code for this computer."""

from typing import TYPE_CHECKING

import typer

from ..util.console import screen, write_json, write_note
from ..util.errors import UserError
from ..util.files import writing
from ._options import Json

if TYPE_CHECKING:
    from pathlib import Path


GROUP = typer.Typer(help="Make the control core ten times as fast on this computer.", no_args_is_help=True)


@GROUP.command()
def build(as_json: Json = False) -> int:
    """Compile shared/ for this Python. Every caramelo command uses the result until a source changes.

    This takes a minute on a PC and several on a Raspberry Pi, and needs a C compiler. The result computes the same
    numbers to the bit (caramelo parity --runtime cpython-compiled shows it). CARAMELO_CORE=source runs without it.

    Example: caramelo core build
    """
    from ..boards.build.native_core import build_core
    from ..boards.core import home, kept_cores, sources_id, usable_core

    _allow()
    found = usable_core()
    if found is None:
        write_note("compiling shared/: takes a minute on a PC and several on a Raspberry Pi")
        found = home() / sources_id()
        _drop([core for core in kept_cores() if core == found])  # one that can't be loaded
        with writing(home()):
            build_core(found)
    _drop([core for core in kept_cores() if core != found])
    return _tell(as_json)


@GROUP.command()
def show(as_json: Json = False) -> int:
    """Show whether there is a compiled core, and whether it was made from these sources.

    Example: caramelo core show --json
    """
    return _tell(as_json)


@GROUP.command()
def remove(as_json: Json = False) -> int:
    """Remove the compiled core, so that the sources run again.

    Example: caramelo core remove
    """
    from ..boards.core import kept_cores

    _allow()
    _drop(kept_cores())
    return _tell(as_json)


def _drop(cores: "list[Path]") -> None:
    import shutil

    for core in cores:
        try:
            shutil.rmtree(core)
        except OSError as error:
            raise UserError(f"{core}: can't be removed: {error.strerror}") from error


def _allow() -> None:
    from ..boards.core import SWITCH, turned_off

    if turned_off():
        raise UserError(f"{SWITCH}=source turns the compiled core off: unset it first")


def _tell(as_json: bool) -> int:
    from ..boards.core import find_core, kept_cores, turned_off, usable_core

    found = usable_core()
    if as_json:
        write_json({"compiled": found is not None, "folder": str(found) if found else None})
    elif turned_off():
        screen().print("the core runs from its sources: CARAMELO_CORE=source turns the compiled one off",
                       soft_wrap=True)
    elif found:
        screen().print(f"the core runs as machine code, from {found}", soft_wrap=True)
    elif find_core():
        screen().print("the core runs from its sources: the compiled one can't be loaded; build it again: "
                       "caramelo core build", soft_wrap=True)
    elif kept_cores():
        screen().print("the core runs from its sources: the compiled one was made from others; build it again: "
                       "caramelo core build", soft_wrap=True)
    else:
        screen().print("the core runs from its sources; to compile it: caramelo core build", soft_wrap=True)
    return 0
