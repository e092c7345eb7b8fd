"""Looks at a robot without moving it: what a running drive tells on its socket, or joints and sensor for some time."""

import json
import socket
import stat
import time
from contextlib import AbstractContextManager, ExitStack
from math import inf
from pathlib import Path
from typing import Any

from ..control.hardware import Hardware
from ..control.health import BAD, OK, Finding, version_finding
from ..control.loop import Loop
from ..control.opening import open_supervisor
from ..control.telemetry import Extra, StartCheck, about, status
from ..imu.attitude import Attitude
from ..imu.base import Imu
from ..robot.model import Robot
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.version import versions

SERVICE = "/run/caramelo/teleop.sock"  # of host/teleop/service/caramelo.service
ANSWER_S = 3.0  # a drive tells its status 20 times a second
CHUNK = 1 << 16

Seen = tuple[dict[str, Any], dict[str, Any], dict[str, Any]]  # what does not change, the first status, the last


def runs(where: str) -> bool:
    """Return whether a drive may listen there."""
    if where.isdigit():
        return True
    try:
        return stat.S_ISSOCK(Path(where).stat().st_mode)
    except FileNotFoundError:
        return False


def seen_on_socket(where: str, seconds: float) -> Seen:
    """Return what a drive tells on its Unix socket or local port for some time; UserError if nobody does."""
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
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"{where}: no drive answers there: {error}", NOT_ACHIEVED) from None
    raise UserError(f"{where}: the drive hung up", NOT_ACHIEVED)


def seen_by_opening(
    robot: Robot, hardware: AbstractContextManager[Hardware], imu: Imu, seconds: float
) -> Seen | list[Finding]:
    """Open joints and sensor, read for some time with the joints off, close; where that fails, what was found out.

    ``imu`` is looked at if the joints can't be opened.
    """
    checks: list[StartCheck] = []
    with ExitStack() as stack:
        try:
            parts = stack.enter_context(hardware)
            supervisor = open_supervisor(stack, robot, parts, checks.append)
        except UserError as error:
            stack.close()
            told = version_finding({**versions(), "joints": ""})
            return [_failed(checks, error), _sensor(Attitude(robot, imu)), told]
        loop = Loop(supervisor)
        constant, first, extra = about(robot, parts), status(loop, Extra()), Extra()
        loop.run(Until(loop, seconds))
        extra.attitude_note = parts.attitude.fault or parts.attitude.note
        extra.readings_missed = parts.attitude.missed
        return constant, first, status(loop, extra)


class Until:
    """A source without commands that ends the loop after some time."""

    came_s = inf

    def __init__(self, loop: Loop, seconds: float) -> None:
        self._loop, self._end_s = loop, loop.clock() + seconds

    def poll(self, timeout_s: float) -> None:
        """See host.control.loop.Source."""
        time.sleep(timeout_s)
        if self._loop.clock() >= self._end_s:
            self._loop.end()


def _failed(checks: list[StartCheck], error: UserError) -> Finding:
    """Return the start-up check that failed, or that the joints can't be opened."""
    failed = next((check for check in checks if not check.ok), None)
    return Finding("joints", BAD, str(error)) if failed is None else Finding(failed.name, BAD, failed.result)


def _sensor(attitude: Attitude) -> Finding:
    """Return whether the sensor answers."""
    try:
        attitude.open()
        attitude.update()
    finally:
        attitude.close()
    fault = attitude.fault
    return Finding("IMU", BAD, fault) if fault else Finding("IMU", OK, f"{attitude.source.kind} answers")
