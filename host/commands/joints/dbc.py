"""`caramelo joints dbc`: writes the protocol in a form that other tools read."""

from pathlib import Path
from typing import Annotated

import typer

from ...util.console import say, tell_written, write_json
from ...util.errors import UserError
from .options import Json


def dbc(
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Write here instead of to the terminal.")] = None,
    as_json: Json = False,
) -> int:
    """Write the protocol as a DBC file with a message for each identifier, for SavvyCAN, Kvaser's tools and cantools.

    Example: caramelo joints dbc --out joints.dbc
    """
    from ...protocol import dbc as source
    from ...protocol.generate_docs import expanded_dbc
    from ...util.files import write_text

    if as_json and out is None:
        raise UserError("--json: a DBC file is not JSON; name the file with --out FILE")
    text = expanded_dbc(source.load())
    if out is None:
        say(text.removesuffix("\n"))
        return 0
    write_text(out, text)
    if as_json:
        write_json({"file": str(out), "bytes": len(text.encode())})
    else:
        tell_written([out])
    return 0
