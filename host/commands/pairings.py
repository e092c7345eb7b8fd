"""`caramelo pairings`: lists the browsers that may drive, and revokes them."""

from pathlib import Path
from typing import Annotated

import typer

from ..util.console import say, write_json
from ..util.errors import UserError
from ._options import Json


def pairings(
    folder: Annotated[Path | None, typer.Option(metavar="DIR", help="For the service: /var/lib/caramelo.")] = None,
    forget: Annotated[bool, typer.Option("--forget", help="Revoke all pairings and disconnect open pages.")] = False,
    as_json: Json = False,
) -> None:
    """Print how many browsers are paired with the page, and since when; --forget revokes all pairings.

    A browser stays paired over a restart. A running drive notices the change within a second.

    Examples: caramelo pairings; sudo caramelo pairings --folder /var/lib/caramelo --forget
    """
    from ..teleop.web.paired import NAME, Paired, paired_path

    path = paired_path() if folder is None else folder / NAME
    paired = Paired(path)
    days = list(paired.browsers().values())
    if forget and days:
        paired.forget_all()
        if paired.trouble:
            raise UserError(paired.trouble)
    if as_json:
        write_json({"file": str(path), "paired_since": days, "forgotten": forget})
        return
    said = "browser is" if len(days) == 1 else "browsers are"
    say(f"{len(days)} {said} {'no longer ' if forget else ''}paired ({path})")
    for day in days:
        say(f"since {day}")
