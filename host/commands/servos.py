"""`caramelo servos`: sets up, finds, watches and switches the robot's servos."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import live_table, make_table, print_table, progress, screen, write_error, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Json, RobotName
from ._servo_setup import setup

if TYPE_CHECKING:
    from ..bus.base import Measured
    from ..bus.dynamixel.bus import ServoBus
    from ..bus.dynamixel.calibration.data import Calibration
    from ..bus.dynamixel.link import Link
    from ..robot.model import Robot

Port = Annotated[str | None, typer.Option(help="Serial port (default: the robot file's).")]
Baud = Annotated[int | None, typer.Option(help="Rate (default: the robot file's).")]
Sim = Annotated[bool, typer.Option("--sim", help="Talk to twelve emulated servos behind a pseudo-terminal.")]
Data = Annotated[Path | None, typer.Option("--calibration", metavar="FILE", help="Default: the robot's own.")]
Servo = Annotated[int, typer.Argument(metavar="ID", min=0, max=252, help="The servo's id.")]

GROUP = typer.Typer(help="Set up, find, watch and switch the servos.", no_args_is_help=True)
GROUP.command()(setup)


@contextmanager
def servo_port(robot: str, port: str | None, baud: int | None, sim: bool) -> Iterator[tuple["Robot", "Link"]]:
    """Yield the robot and an open link to its servos, real or emulated."""
    from ..bus.dynamixel.link import open_link, serial_bus
    from ..robot.file import find, load_robot

    data = load_robot(robot)
    serial_bus(data)
    _check_rate(baud)
    with ExitStack() as stack:
        if sim:
            from ..sim.servos.process import Emulator

            port = stack.enter_context(Emulator("--robot", str(find(robot)))).port
        yield data, stack.enter_context(open_link(data, port, baud))


def _check_rate(baud: int | None) -> None:
    from ..bus.dynamixel.table import BAUDS

    if baud is not None and baud not in BAUDS:
        raise UserError(f"--baud {baud}: allowed {', '.join(map(str, BAUDS))}")


def _calibration(robot: "Robot", path: Path | None, sim: bool) -> "Calibration | None":
    """Return the robot's calibration; None if it has none yet and the command names none."""
    from ..bus.dynamixel.calibration.data import default_path, load_calibration, nominal

    if path is not None:
        return load_calibration(path, robot)
    if sim:
        return nominal(robot)
    return load_calibration(default_path(robot), robot) if default_path(robot).exists() else None


def _joints(calibration: "Calibration | None") -> dict[int, str]:
    from ..bus.base import JOINT_LABELS

    return dict(zip(calibration.ids, JOINT_LABELS, strict=True)) if calibration else {}


def _nobody(link: "Link") -> str:
    """Return what to do where no servo answers at all."""
    rate, name = link.port.getBaudRate(), link.port.port_name
    again = "caramelo servos scan --all-bauds"
    return f"no servo answers on {name} at {rate} baud: is the power on? try: {again}, or another --port"


@GROUP.command()
def scan(
    robot: RobotName = "caramelo",
    port: Port = None,
    baud: Baud = None,
    all_bauds: Annotated[bool, typer.Option("--all-bauds", help="Try every rate, which takes half a minute.")] = False,
    calibration: Data = None,
    sim: Sim = False,
    as_json: Json = False,
) -> int:
    """Find all servos on the bus. Exit code 1 if there is none.

    Examples: caramelo servos scan; caramelo servos scan --all-bauds --port /dev/ttyUSB1; caramelo servos scan --sim
    """
    from ..bus.base import JOINTS
    from ..bus.dynamixel import budget as costs
    from ..bus.dynamixel.port import latency_ms, latency_warning
    from ..bus.dynamixel.tools import find, find_at_all_rates

    with servo_port(robot, port, baud, sim) as (data, link), progress("scan", 1.0) as done:
        found = list(find_at_all_rates(link, done)) if all_bauds else find(link, done)
        name, waits_ms = link.port.port_name, latency_ms(link.port.port_name)
        nobody = _nobody(link)
        warning, rate, protocol = latency_warning(name), link.port.getBaudRate(), link.protocol
    joints = _joints(_calibration(data, calibration, sim))
    cost = costs.budget(
        rate, data.control.rate_hz, protocol, costs.WELL_SET_LATENCY_MS if waits_ms is None else waits_ms
    )
    rows = [{**asdict(one), "name": one.text, "joint": joints.get(one.id)} for one in found]
    if as_json:
        write_json({"port": name, "servos": rows, "warning": warning, "budget": cost.as_dict()})
    else:
        cells = [(r["id"], r["joint"] or "-", r["name"], r["baud"]) for r in rows]
        print_table(("id", "joint", "model", "baud"), cells)
        screen().print(f"{len(rows)} servos on {name}\n{cost.sentence()}", soft_wrap=True)
        if 1 < len(rows) < JOINTS:
            write_error(f"warning: a robot has {JOINTS} servos: check the cables; servos with the same id count as one")
        if warning:
            write_error(f"warning: {warning}")
    if not rows:
        write_error(nobody)
    return 0 if rows else NOT_ACHIEVED


@GROUP.command()
def status(
    robot: RobotName = "caramelo",
    port: Port = None,
    baud: Baud = None,
    calibration: Data = None,
    sim: Sim = False,
    as_json: Json = False,
) -> int:
    """Show position, load, voltage, temperature and errors of each servo. Exit code 1 if one is silent or tripped.

    Example: caramelo servos status
    """
    from ..bus.dynamixel.tools import status as status_of

    with servo_port(robot, port, baud, sim) as (data, link):
        known = _joints(_calibration(data, calibration, sim))
        ids = sorted(known) if known else range(1, 13)
        rows = []
        with progress("status", len(ids)) as done:
            for servo in ids:
                rows.append((known.get(servo, "-"), servo, status_of(link, servo)))
                done(len(rows))
        nobody = _nobody(link)
    silent = [f"{joint} (id {servo})" if known else f"id {servo}" for joint, servo, s in rows if s is None]
    if as_json:
        write_json({"servos": [
            {"joint": joint, "id": servo, "silent": s is None, **(asdict(s) if s else {})} for joint, servo, s in rows
        ]})  # fmt: skip
    else:
        head = ("joint", "id", "position", "load", "V", "C", "torque", "error")
        print_table(head, [(joint, servo, *_status_cells(s)) for joint, servo, s in rows])
    if len(silent) == len(rows):
        write_error(nobody)
    elif silent:
        write_error(f"silent: {', '.join(silent)}: check the plugs and cables there, then run: caramelo servos scan")
    return 0 if all(s and not s.error for _, _, s in rows) else NOT_ACHIEVED


def _status_cells(s: Any) -> tuple[object, ...]:
    if s is None:
        return "-", "-", "-", "-", "-", "silent"
    load, torque = f"{100 * s.load:.0f} %", "on" if s.torque else "off"
    return s.position, load, f"{s.voltage_V:.1f}", s.temperature_C, torque, s.error or "none"


@contextmanager
def _open_bus(robot: str, port: str | None, calibration: Path | None, sim: bool) -> Iterator["ServoBus"]:
    from ..bus.dynamixel.bus import ServoBus
    from ..robot.file import load_robot
    from ._hardware import hardware

    with hardware(load_robot(robot), "emulated" if sim else "real", port, calibration, robot) as parts:
        assert isinstance(parts.bus, ServoBus)
        with parts.bus as bus:
            for warning in bus.warnings:
                write_error(f"warning: {warning}")
            yield bus


@GROUP.command()
def monitor(
    robot: RobotName = "caramelo",
    port: Port = None,
    calibration: Data = None,
    seconds: Annotated[float | None, typer.Option(min=0.0, help="Stop after this time (default: on Ctrl-C).")] = None,
    sim: Sim = False,
    as_json: Json = False,
) -> int:
    """Watch all joints with the torque off: turn them by hand and see angle, load, voltage, heat and bus errors.

    Example: caramelo servos monitor --sim --seconds 2
    """
    with _open_bus(robot, port, calibration, sim) as bus:
        measured = _watch(bus, seconds, None if as_json else _live)
        if as_json:
            write_json({"joints": _joint_rows(bus, measured), "bus": bus.counters.as_dict()})
    return 0


def _watch(bus: "ServoBus", seconds: float | None, view: Callable[..., Any] | None) -> "Measured":
    """Read at the planner's rate until the time is over or Ctrl-C; show the reading ten times a second."""
    period_s, began_s = 1 / bus.robot.control.rate_hz, bus.now()
    measured, shown_s = bus.read(), began_s
    with view() if view else nullcontext() as show, suppress(KeyboardInterrupt):
        while seconds is None or bus.now() - began_s < seconds:
            time.sleep(period_s)
            measured = bus.read()
            if show and bus.now() - shown_s > 0.1:
                shown_s = bus.now()
                show(bus, measured)
    return measured


@contextmanager
def _live() -> Iterator[Callable[["ServoBus", "Measured"], None]]:
    """Yield a function that shows a reading."""
    with live_table() as show:
        yield lambda bus, measured: show(_joint_table(bus, measured))


def _joint_rows(bus: "ServoBus", m: "Measured") -> list[dict[str, Any]]:
    from math import degrees, isinf

    return [
        {
            "joint": bus.name(joint),
            "angle_deg": round(degrees(m.position_rad[joint]), 2),
            "load": round(m.load[joint], 3),
            "voltage_V": round(m.voltage_V[joint], 1),
            "temperature_C": m.temperature_C[joint],
            "error": m.error[joint],
            "age_s": None if isinf(m.age_s[joint]) else round(m.age_s[joint], 3),
        }
        for joint in range(len(m.position_rad))
    ]


def _joint_table(bus: "ServoBus", measured: "Measured") -> Any:
    cells = [
        (
            row["joint"], f"{row['angle_deg']:.1f}", f"{100 * row['load']:.0f} %", f"{row['voltage_V']:.1f}",
            f"{row['temperature_C']:.0f}", row["error"] or "none",
        )
        for row in _joint_rows(bus, measured)
    ]  # fmt: skip
    c = bus.counters
    caption = f"{c.sent} asked, {c.answered} answered, {c.lost} lost, {c.corrupted} damaged, {c.wrong} wrong"
    return make_table(("joint", "deg", "load", "V", "C", "error"), cells, caption)


@GROUP.command()
def torque(
    switch: Annotated[
        str, typer.Argument(metavar="on|off", help="on: hold the present pose until Ctrl-C; off: let go.")
    ],
    robot: RobotName = "caramelo",
    port: Port = None,
    baud: Baud = None,
    calibration: Data = None,
    limit: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the stall torque to hold with.")] = 0.5,
    seconds: Annotated[float | None, typer.Option(min=0.0, help="on: let go after this time.")] = None,
    sim: Sim = False,
) -> int:
    """Hold the present pose while this runs, or switch off all servos on the bus, calibrated or not.

    Examples: caramelo servos torque off; caramelo servos torque on --limit 0.2
    """
    if switch not in ("on", "off"):
        raise UserError(f"torque {switch}: allowed on, off")
    if switch == "off":
        from ..bus.dynamixel.table import TORQUE_ENABLE

        with servo_port(robot, port, baud, sim) as (_, link):
            for _ in range(3):  # no servo confirms a broadcast
                link.broadcast(TORQUE_ENABLE, 0)
        screen().print("told all servos on the bus to let go")
        return 0
    with _open_bus(robot, port, calibration, sim) as bus:
        bus.limit_torque(limit)
        bus.torque(True)
        screen().print("holding; Ctrl-C lets go")
        _watch(bus, seconds, None)
    return 0


@GROUP.command()
def set_id(
    old: Servo,
    new: Annotated[int, typer.Argument(metavar="NEW", min=0, max=252, help="The new id.")],
    robot: RobotName = "caramelo",
    port: Port = None,
    baud: Baud = None,
    sim: Sim = False,
) -> int:
    """Give a servo another id. Refused if the id is taken.

    Example: caramelo servos set-id 1 7
    """
    from ..bus.dynamixel import tools

    with servo_port(robot, port, baud, sim) as (_, link):
        tools.set_id(link, old, new)
    screen().print(f"servo {old} now has id {new}")
    return 0


@GROUP.command()
def set_baud(
    servo: Servo,
    new: Annotated[int, typer.Argument(metavar="BAUD", help="The new rate.")],
    robot: RobotName = "caramelo",
    port: Port = None,
    baud: Baud = None,
    sim: Sim = False,
) -> int:
    """Set a servo's rate. All servos on a bus need the same rate.

    Example: caramelo servos set-baud 1 4000000 --baud 57600
    """
    from ..bus.dynamixel import tools

    with servo_port(robot, port, baud, sim) as (_, link):
        tools.set_baud(link, servo, new)
    screen().print(f"servo {servo} now talks at {new} baud")
    return 0


@GROUP.command()
def reboot(servo: Servo, robot: RobotName = "caramelo", port: Port = None, baud: Baud = None, sim: Sim = False) -> int:
    """Restart a servo that has tripped. It lets go while it restarts.

    Example: caramelo servos reboot 5
    """
    with servo_port(robot, port, baud, sim) as (_, link):
        link.reboot(servo)
    screen().print(f"servo {servo} restarts")
    return 0


@GROUP.command()
def budget(
    robot: RobotName = "caramelo",
    baud: Baud = None,
    latency: Annotated[float, typer.Option(metavar="MS", min=0, max=255, help="The adapter's latency timer.")] = 1.0,
    as_json: Json = False,
) -> int:
    """Print how much of a control cycle the bus takes. Exit code 1 if it does not fit.

    Example: caramelo servos budget --baud 1000000 --latency 16
    """
    from ..bus.dynamixel.budget import budget as budget_of
    from ..bus.dynamixel.link import serial_bus
    from ..robot.file import load_robot

    data = load_robot(robot)
    own = serial_bus(data)
    _check_rate(baud)
    cost = budget_of(baud or own.baud, data.control.rate_hz, own.protocol, latency)
    if as_json:
        write_json(cost.as_dict())
    else:
        screen().print(cost.sentence(), soft_wrap=True)
    return 0 if cost.fits else NOT_ACHIEVED
