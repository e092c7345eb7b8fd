"""`caramelo health`: how the robot is, one line with a verdict for each part."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import say, write_json, write_note
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Json, RobotName

if TYPE_CHECKING:
    from ..control.health import Finding
    from ..imu.attitude import Attitude

LOOK_S = 2.0  # the sensor needs one of them to find out where up is
SETTLE_S = 1.5  # a simulated robot first sinks onto its folded legs, which its sensor takes for being moved


def health(
    robot: RobotName = "caramelo",
    sim: Annotated[bool, typer.Option("--sim", help="Check emulated servos or simulated joints.")] = False,
    direct: Annotated[bool, typer.Option("--direct", help="With --sim: no servo bus in between.")] = False,
    socket: Annotated[str | None, typer.Option(metavar="WHERE", help="The --socket of a running drive.")] = None,
    port: Annotated[str | None, typer.Option(help="Serial port, or INTERFACE:CHANNEL of CAN.")] = None,
    imu: Annotated[str | None, typer.Option(metavar="WHERE", help="i2c, a gait board's port, or a recording.")] = None,
    calibration: Annotated[Path | None, typer.Option(metavar="FILE", help="Default: the robot's own.")] = None,
    seconds: Annotated[float, typer.Option(metavar="S", help="How long to look at it, s.")] = LOOK_S,
    as_json: Json = False,
) -> int:
    """Print how the robot is: loop, missed deadlines, bus errors by joint, IMU, battery, hottest joint, versions.

    The command asks a running service, which disturbs nothing. If none runs, it opens joints and sensor and reads them
    with the joints off. It can't touch a robot that another program holds up, because the port is taken. Each line says
    ok, note or bad. Exit code 1 if anything is bad.

    Examples: caramelo health; caramelo health --sim --json; caramelo health --robot parallel --port socketcan:can0
    """
    from ..control.health import findings
    from ..teleop.look import SERVICE, runs, seen_on_socket

    if not LOOK_S <= seconds <= 600:
        raise UserError(f"--seconds {seconds:g}: allowed {LOOK_S:g} .. 600 s")
    if direct and not sim:
        raise UserError("--direct: only with --sim")
    if sim and socket is not None:
        raise UserError("--sim: not with --socket, which asks a running drive")
    opens = sim or port is not None or imu is not None or calibration is not None
    where = socket if socket is not None else SERVICE if not opens and runs(SERVICE) else None
    found: Sequence[Finding]
    if where is not None:
        write_note(f"asking the drive at {where}")
        found = tuple(findings(*seen_on_socket(where, seconds)))
    else:
        found = _opened(robot, sim, direct, port, calibration, imu, seconds)
    return _tell(found, where or ("simulation" if sim else "opened"), as_json)


def _opened(
    name: str, sim: bool, direct: bool, port: str | None, calibration: Path | None, imu: str | None, seconds: float
) -> "Sequence[Finding]":
    """Open the robot for some time and return its lines; if that fails, why, and whether the sensor answers."""
    from ..control.health import BAD, Finding, version_finding
    from ..imu.attitude import Attitude
    from ..imu.choose import I2C, open_source
    from ..library.errors import Error
    from ..library.places import Place
    from ..library.robot import Robot
    from ..robot.file import find, load_robot
    from ..util.version import versions
    from ._hardware import hardware, kind_of_hardware

    robot = load_robot(name)
    if not sim and robot.bus.kind == "none":
        raise UserError(f"{robot.name}: can only be simulated, not driven: add --sim")
    sensor = Attitude(robot, open_source(robot, imu or I2C))
    write_note(f"reading {robot.name} for {seconds:g} s, joints off")
    try:
        which = kind_of_hardware(robot, sim, direct)
        chosen = hardware(robot, which, port, calibration, str(find(name)), imu)
        with chosen as parts, Robot(Place(parts), name) as opened:
            if sim:
                opened.health(SETTLE_S)
            return opened.health(seconds)
    except (UserError, Error) as error:
        return [Finding("joints", BAD, str(error)), _answers(sensor), version_finding({**versions(), "joints": ""})]


def _answers(sensor: "Attitude") -> "Finding":
    """Return whether the sensor answers."""
    from ..control.health import BAD, OK, Finding

    try:
        sensor.open()
        sensor.update()
    finally:
        sensor.close()
    return Finding("IMU", BAD, sensor.fault) if sensor.fault else Finding("IMU", OK, f"{sensor.source.kind} answers")


def _tell(found: "Sequence[Finding]", source: str, as_json: bool) -> int:
    bad = [each for each in found if each.verdict == "bad"]
    if as_json:
        lines = [{"name": each.name, "verdict": each.verdict, "found": each.found} for each in found]
        write_json({"ok": not bad, "source": source, "lines": lines})
    else:
        for each in found:
            say(f"{each.name:<9}  {each.verdict:<4}  {each.found}")
    return NOT_ACHIEVED if bad else 0
