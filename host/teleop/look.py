"""Watches a robot that another program drives, by the status on that program's socket."""

import json
import socket
import stat
import time
from pathlib import Path
from typing import Any

from ..util.errors import NOT_ACHIEVED, UserError

SERVICE = "/run/caramelo/teleop.sock"  # of host/teleop/service/caramelo.service
ANSWER_S = 3.0  # a drive sends its status 20 times a second
CHUNK = 1 << 16

Seen = tuple[dict[str, Any], dict[str, Any], dict[str, Any]]  # the constant data, the first status, the last


def runs(where: str) -> bool:
    """Return whether a drive might listen there."""
    if where.isdigit():
        return True
    try:
        return stat.S_ISSOCK(Path(where).stat().st_mode)
    except FileNotFoundError:
        return False


def seen_on_socket(where: str, seconds: float) -> Seen:
    """Return a drive's data from its Unix socket or local port over some time; UserError if no drive answers."""
    family, address = (socket.AF_INET, ("127.0.0.1", int(where))) if where.isdigit() else (socket.AF_UNIX, where)
    said: dict[str, list[dict[str, Any]]] = {"hello": [], "status": []}
    try:
        with socket.socket(family) as stream:
            stream.settimeout(ANSWER_S)
            stream.connect(address)
            end_s = time.monotonic() + seconds
            for line in stream.makefile("rb"):
                news = json.loads(line)
                said.setdefault(news["type"], []).append(news)
                if said["hello"] and len(said["status"]) > 1 and time.monotonic() > end_s:
                    return said["hello"][0], said["status"][0], said["status"][-1]
    except PermissionError:
        raise UserError(f"{where}: only the user who started the drive and root may ask: use sudo") from None
    except (OSError, OverflowError, ValueError, KeyError) as error:
        raise UserError(f"{where}: no drive answers there: {error}", NOT_ACHIEVED) from None
    raise UserError(f"{where}: the drive hung up", NOT_ACHIEVED)
