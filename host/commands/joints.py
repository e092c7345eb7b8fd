"""`caramelo joints`: finds, looks at, arms, numbers and sets the brushless joints on CAN, and simulates them."""

import json
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import screen, write_error, write_json
from ..errors import NOT_ACHIEVED, UserError
from . import HARDWARE

if TYPE_CHECKING:
    from ..buses.can_joints import CanJoints
    from ..joints.link import JointView

RobotName = Annotated[str, typer.Option("--robot", help="A robot's name, or a file ending in .toml.")]
Interface = Annotated[
    str | None,
    typer.Option(help="socketcan, slcan, gs_usb, virtual or udp_multicast; without it the robot file's own."),
]
Channel = Annotated[str | None, typer.Option(help="can0, a serial port, an adapter's number or a multicast group.")]
Sim = Annotated[bool, typer.Option("--sim", help="Talk to joints simulated in this process, in simulated time.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Node = Annotated[int, typer.Argument(metavar="NODE", min=1, max=12, help="1 + 3 x leg + joint.")]
Seconds = Annotated[float | None, typer.Option(min=0.0, help="Stop after so long; without it on Ctrl-C.")]


def register(app: typer.Typer) -> None:
    """Add the group to the command."""
    group = typer.Typer(
        help="Find, look at, arm, number and set the CAN joints, or simulate them.", no_args_is_help=True
    )
    commands: dict[str, Callable[..., int]] = {
        "scan": scan,
        "status": status,
        "monitor": monitor,
        "arm": arm,
        "disarm": disarm,
        "clear": clear,
        "set-id": set_id,
        "calibrate": calibrate,
        "busload": busload,
        "sim": sim,
    }
    for name, command in commands.items():
        group.command(name)(command)
    params = typer.Typer(help="Read, write, keep and compare the joints' parameters.", no_args_is_help=True)
    parts: dict[str, Callable[..., int]] = {"get": get, "set": set_, "save": save, "restore": restore, "diff": diff}
    for name, command in parts.items():
        params.command(name)(command)
    group.add_typer(params, name="params")
    app.add_typer(group, name="joints", rich_help_panel=HARDWARE)


@contextmanager
def joints(robot: str, interface: str | None, channel: str | None, simulated: bool) -> Iterator["CanJoints"]:
    """Yield the joints of a robot, listened to for two heartbeats but not checked."""
    from ..buses.can_joints import LISTEN_S, CanJoints
    from ..emulator.plant import seated_pose_rad
    from ..robot_file import load_robot

    data = load_robot(robot)
    if data.bus.kind != "can":
        raise UserError(f"{data.name} has no joints on CAN; try --robot parallel")
    session = 1 + secrets.randbelow(255)
    if simulated:
        from ..joints.sim_robot import SimPort, SimRobot

        port: Any = SimPort(SimRobot(data))
    else:
        from ..can.adapter import AdapterPort

        port = AdapterPort(interface or data.bus.interface, channel or data.bus.channel, data.bus.bitrate)
    bus = CanJoints(data, port, session, seated_pose_rad(data), report=lambda notice: write_error(notice.sentence))
    try:
        bus.run_for(LISTEN_S)
        yield bus
    finally:
        if simulated:
            port.sim.close()
        port.close()


def scan(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """List the boards on the bus, and what keeps the robot from being armed. Exit code 1 if anything does.

    Example: caramelo joints scan --sim
    """
    with joints(robot, interface, channel, sim) as bus:
        boards = bus.requests.discover()
        wrong = bus.cycle.guard.before_arming(boards)
        trouble = bus.port.trouble
    rows = [(node, number) for node, numbers in sorted(boards.items()) for number in sorted(numbers)]
    if as_json:
        write_json({
            "boards": [{"node": node, "board": number} for node, number in rows],
            "wrong": [{"node": n.node, "what": n.what, "sentence": n.sentence} for n in wrong],
        })  # fmt: skip
    else:
        from ..joints.service import joint_name

        _print(("joint", "board"), [(joint_name(node), f"{number:#010x}") for node, number in rows])
        for sentence in [*(notice.sentence for notice in wrong), *filter(None, [trouble])]:
            screen().print(sentence, soft_wrap=True)
    return NOT_ACHIEVED if wrong else 0


def _row(bus: "CanJoints", view: "JointView") -> dict[str, Any]:
    from math import isinf

    from shared.wire import names as w

    from ..joints.service import joint_name
    from ..protocol.frames import describe, encode

    age_s = bus.now() - view.heartbeat_s
    if isinf(age_s) or age_s > 1.0:
        return {"joint": joint_name(view.node), "state": "not there", "fault": "check its power and the CAN cable"}
    heartbeat = describe(w.HEARTBEAT_ID + view.node, encode(w.HEARTBEAT_ID + view.node, list(view.heartbeat))[0]) or {}
    slow = describe(w.SLOW_STATUS_ID + view.node, encode(w.SLOW_STATUS_ID + view.node, list(view.status))[0]) or {}
    position = view.reply[w.REPLY_POSITION]
    return {
        "joint": joint_name(view.node),
        "state": str(heartbeat["state"]).replace("_", " "),
        "mode": heartbeat["mode"],
        "motor_deg": None if position == w.NOT_AVAILABLE else round(position * 360 / 65536, 2),
        "current_A": round(view.reply[w.REPLY_CURRENT] / 4096, 3),
        "bus_V": slow["bus_voltage"],
        "winding_C": slow["winding_temperature"],
        "board_C": slow["mcu_temperature"],
        "limits": slow["limits"],
        "lost": view.lost,
        "late": view.late,
        "fault": bus.cycle.guard.fault_text(view) if view.heartbeat[w.HEARTBEAT_FAULT] else "none",
    }


# Column and its heading; faults stand below the table, because they are sentences
_COLUMNS = {
    "state": "state",
    "motor_deg": "deg",
    "current_A": "A",
    "bus_V": "V",
    "winding_C": "C",
    "limits": "limits",
    "lost": "lost",
    "late": "late",
}


def _rows(bus: "CanJoints") -> list[dict[str, Any]]:
    return [_row(bus, bus.link.views[node]) for node in bus.link.nodes]


def _table(rows: list[dict[str, Any]]) -> Any:
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    table = Table("joint", *_COLUMNS.values(), box=None, pad_edge=False)
    for row in rows:
        cells = (row.get(key) for key in _COLUMNS)
        shown = ["-" if v is None else f"{v:.1f}" if isinstance(v, float) else str(v) for v in cells]
        table.add_row(str(row["joint"]).replace("node ", ""), *shown)
    wrong = [Text(f"{row['joint']}: {row['fault']}") for row in rows if row["fault"] != "none"]
    return Group(table, *wrong)


def _print(head: tuple[str, ...], rows: list[tuple[Any, ...]]) -> None:
    from rich.table import Table

    table = Table(*head, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*map(str, row))
    screen().print(table)


def status(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Show every joint's state, limits, losses, and its fault in words. Exit code 1 if one is missing or in fault.

    Example: caramelo joints status --interface udp_multicast --channel default
    """
    with joints(robot, interface, channel, sim) as bus:
        rows, counters = _rows(bus), bus.port.counters.as_dict()
        trouble = bus.port.trouble
    if as_json:
        write_json({"joints": rows, "port": counters, "trouble": trouble})
    else:
        screen().print(_table(rows))
        screen().print(", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counters.items()))
        if trouble:
            screen().print(trouble, soft_wrap=True)
    return 0 if all(row["fault"] == "none" for row in rows) else NOT_ACHIEVED


def monitor(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, seconds: Seconds = None,
    out: Annotated[Path | None, typer.Option(help="Record what every joint said, one JSON object a line.")] = None,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Watch all joints, as a live table; nothing is armed. Records with --out.

    Example: caramelo joints monitor --sim --seconds 2 --out joints.jsonl
    """
    from rich.live import Live

    from ..files import write_text

    lines: list[str] = []
    with joints(robot, interface, channel, sim) as bus, Live(console=screen(), auto_refresh=False) as live:
        began_s = bus.now()
        try:
            while seconds is None or bus.now() - began_s < seconds:
                bus.run_for(0.1)
                rows = _rows(bus)
                live.update(_table(rows), refresh=True)
                if out is not None:
                    lines.append(json.dumps({"time_s": round(bus.now() - began_s, 3), "joints": rows}))
        except KeyboardInterrupt:
            screen().print("stopped")
    if out is not None:
        write_text(out, "".join(line + "\n" for line in lines))
    return 0


def arm(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, seconds: Seconds = None,
    limit: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the current limit to hold with.")] = 0.5,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Arm all joints where they are and hold them while this runs; then disarm. Exit code 1 if one gives up.

    Example: caramelo joints arm --sim --seconds 1
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.open()
        bus.limit_torque(limit)
        console = screen()  # loading it takes longer than the joints' watchdog waits
        console.print("arming; Ctrl-C disarms")
        bus.torque(True)
        began_s = bus.now()
        try:
            while bus.cycle.armed and (seconds is None or bus.now() - began_s < seconds):
                bus.run_for(0.05)
        except KeyboardInterrupt:
            screen().print("stopped")
        gave_up = bus.cycle.reaction == "damp"
        bus.torque(False)
        timing = bus.cycle.timing.as_dict()
    screen().print(f"disarmed; cycles started late: {timing['late']}, left out: {timing['skipped']}", soft_wrap=True)
    return NOT_ACHIEVED if gave_up else 0


def disarm(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Disarm all joints, whoever armed them.

    Example: caramelo joints disarm
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.torque(False)
    screen().print("all joints were told to let go")
    return 0


def clear(robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False) -> int:
    """Clear latched faults. Arms nothing. Exit code 1 while a cause is still there.

    Example: caramelo joints clear
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.clear()
    screen().print("no fault is latched")
    return 0


def set_id(
    board: Annotated[str, typer.Argument(metavar="BOARD", help="The board's number, as joints scan shows it.")],
    node: Annotated[int, typer.Argument(metavar="NODE", min=0, max=12, help="The node it gets; 0 takes it away.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Give a board another node, and keep it. Refused if another board has that node.

    Example: caramelo joints set-id 0x2ab1c2d3 5
    """
    from shared.wire import names as w

    try:
        number = int(board, 0)
    except ValueError as error:
        raise UserError(f"BOARD {board}: give a number such as 0x2ab1c2d3") from error
    with joints(robot, interface, channel, sim) as bus:
        taken = bus.requests.discover().get(node, set()) - {number}
        if node and taken:
            raise UserError(f"node {node} is taken by board {min(taken):#x}: give that one another node first")
        bus.requests.to_board(w.COMMAND_SET_ID, number, node)
        bus.run_for(0.05)
        if node:
            bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"board {number:#x} is node {node} now")
    return 0


def calibrate(
    node: Node,
    kind: Annotated[str, typer.Option(help="full: free to turn; small: in an assembled leg; verify.")] = "small",
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Calibrate one joint's motor against its encoder, and keep the result. Exit code 1 with the reason if it fails.

    Simulated joints are calibrated already, and their ideal current loop cannot be.

    Example: caramelo joints calibrate 5 --kind full
    """
    from shared.joint.calibration import CAL_FULL, CAL_SMALL, CAL_VERIFY
    from shared.wire import names as w

    kinds = {"full": CAL_FULL, "small": CAL_SMALL, "verify": CAL_VERIFY}
    if kind not in kinds:
        raise UserError(f"--kind {kind}: allowed {', '.join(kinds)}")
    if sim:
        raise UserError("simulated joints have an ideal current loop, which cannot be calibrated: leave --sim out")
    with joints(robot, interface, channel, sim) as bus:
        view = bus.link.views[node]
        bus.requests.demand(node, w.COMMAND_CALIBRATE, kinds[kind])
        bus.run_for(0.5)
        while view.heartbeat[w.HEARTBEAT_MODE] == w.MODE_CALIBRATING:
            bus.run_for(0.1)
        if view.heartbeat[w.HEARTBEAT_FAULT]:
            raise UserError(bus.cycle.guard.fault_text(view), NOT_ACHIEVED)
        if kind != "verify":
            bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"node {node} is calibrated")
    return 0


def get(
    node: Node,
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME ...]", help="Without any: all.")] = None,
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Read parameters of a joint, in their own units.

    Example: caramelo joints params get 5 current_kp gear_q8 --sim
    """
    from ..joints.params import find_all, read

    wanted = find_all(names)
    with joints(robot, interface, channel, sim) as bus:
        values = {p.name: p.to_value(read(bus.requests, node, p)) for p in wanted}
    if as_json:
        write_json({"node": node, "parameters": values})
    else:
        _print(("parameter", "value", "unit"), [(p.name, f"{values[p.name]:.10g}", p.unit) for p in wanted])
    return 0


def set_(
    node: Node,
    name: Annotated[str, typer.Argument(metavar="NAME")],
    value: Annotated[float, typer.Argument(metavar="VALUE", help="In the parameter's unit.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Write one parameter of a joint until it loses power; params save keeps it.

    Example: caramelo joints params set 5 position_p 900
    """
    from ..joints.params import find_all, write

    with joints(robot, interface, channel, sim) as bus:
        raw = write(bus.requests, node, find_all([name])[0], value)
    screen().print(f"node {node}: {name} is raw {raw} now; params save keeps it")
    return 0


def save(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Keep a joint's parameters over a power cycle.

    Example: caramelo joints params save 5
    """
    from shared.wire import names as w

    with joints(robot, interface, channel, sim) as bus:
        bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"node {node}: parameters are kept")
    return 0


def restore(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Set a joint's parameters back to those of a fresh board, until it loses power; params save keeps them.

    Example: caramelo joints params restore 5
    """
    from shared.wire import names as w

    with joints(robot, interface, channel, sim) as bus:
        bus.requests.demand(node, w.COMMAND_RESTORE_DEFAULTS)
    screen().print(f"node {node}: parameters are those of a fresh board; params save keeps them")
    return 0


def diff(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Show where a joint's parameters differ from a fresh board's.

    Example: caramelo joints params diff 5 --sim
    """
    from ..joints.params import differences

    with joints(robot, interface, channel, sim) as bus:
        rows = differences(bus.requests, node)
    if as_json:
        write_json(
            {"node": node, "different": [{"parameter": p.name, "raw": raw, "fresh": p.default} for p, raw in rows]}
        )
    else:
        _print(
            ("parameter", "raw", "fresh board", "unit of raw"), [(p.name, raw, p.default, p.unit) for p, raw in rows]
        )
    return 0


def busload(
    robot: RobotName = "parallel",
    rate: Annotated[float | None, typer.Option(min=20, max=1000, help="Hz; without it the robot file's.")] = None,
    buses: Annotated[int, typer.Option(min=1, max=2, help="Two buses: front legs on one, rear legs on the other.")] = 1,
    as_json: Json = False,
) -> int:
    """Print how much of the bus the configured schedule takes, worst and typical. Exit code 1 above 70 %.

    Example: caramelo joints busload --rate 400 --buses 2
    """
    from ..busload import busload as busload_of
    from ..busload import default_schedule
    from ..robot_file import load_robot

    data = load_robot(robot)
    if data.bus.kind != "can":
        raise UserError(f"{data.name} has no CAN bus; try --robot parallel")
    kinds = ("velocity",) if data.bus.loops == "host" else ("position",)
    nodes = tuple(range(1, 1 + 12 // buses))
    rows = busload_of(default_schedule(rate or data.bus.rate_hz, nodes, kinds), data.bus.bitrate)
    if as_json:
        write_json({"buses": buses, "rows": [vars(row) for row in rows]})
    else:
        cells = [
            (
                r.name,
                r.length or "",
                f"{r.frames_per_s:.0f}",
                f"{100 * r.worst_share:.2f}",
                f"{100 * r.typical_share:.2f}",
            )
            for r in rows
        ]
        _print(("frame", "bytes", "frames/s", "worst %", "typical %"), cells)
    return 0 if rows[-1].worst_share <= 0.7 else NOT_ACHIEVED


def sim(
    robot: RobotName = "parallel",
    interface: Annotated[str, typer.Option(help="udp_multicast, or socketcan with a vcan channel.")] = "udp_multicast",
    channel: Annotated[str, typer.Option(help="default is python-can's own multicast group.")] = "default",
    fault: Annotated[list[str] | None, typer.Option(help="KIND[:NODE]@SECONDS, such as power-cycle:5@10.")] = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of frames that each node does not hear.")] = 0.0,
    vm: Annotated[int, typer.Option(min=0, max=12, help="So many joints run in MicroPython VMs of their own.")] = 0,
    seconds: Seconds = None,
) -> int:
    """Simulate the robot's twelve joints on a bus: each its own firmware, with the plane as the body.

    Then, from another terminal: caramelo joints status --interface udp_multicast --channel default

    Examples: caramelo joints sim --fault power-cycle:5@10 --loss 0.01; caramelo joints sim --vm 4
    """
    from ..can.adapter import AdapterPort
    from ..joints.gateway import Gateway
    from ..joints.sim_robot import SimRobot
    from ..robot_file import load_robot

    data = load_robot(robot)
    with AdapterPort(interface, channel, 1_000_000) as port:
        robot_sim = SimRobot(data, in_vm=range(1, 1 + vm))
        gateway = Gateway(robot_sim, port)
        for node in robot_sim.nodes:
            node.loss = loss
        for one in fault or ():
            gateway.inject(one)
        screen().print(f"twelve joints on {port.name}; Ctrl-C ends them")
        try:
            gateway.run(seconds)
        except KeyboardInterrupt:
            screen().print("stopped")
        finally:
            robot_sim.close()
    if gateway.behind_s:
        screen().print(f"this machine was too slow by {gateway.behind_s:.1f} s in all")
    return 0
