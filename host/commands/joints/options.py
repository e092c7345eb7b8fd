"""Options that the joints' commands share, and a robot's joints opened with them."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from ...util.console import write_error
from ...util.errors import UserError

if TYPE_CHECKING:
    from ...bus.can.joints import CanJoints
    from ...bus.can.port import Port

NODES = "FR hip 1, thigh 2, calf 3; then FL 4 to 6, RR 7 to 9, RL 10 to 12"
RobotName = Annotated[str, typer.Option("--robot", help="A robot's name, or a file ending in .toml.")]
Interface = Annotated[
    str | None,
    typer.Option(help="socketcan, slcan, gs_usb, virtual or udp_multicast (default: the robot file's)."),
]
Channel = Annotated[str | None, typer.Option(help="can0, a serial port, an adapter's number or a multicast group.")]
Sim = Annotated[bool, typer.Option("--sim", help="Talk to joints simulated in this process, in simulated time.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Node = Annotated[int, typer.Argument(metavar="NODE", min=1, max=12, help=f"{NODES}.")]
Seconds = Annotated[float | None, typer.Option(min=0.0, help="Stop after this time (default: on Ctrl-C).")]
@contextmanager
def joints(
    robot: str, interface: str | None, channel: str | None, simulated: bool, benches: Sequence[int] = ()
) -> Iterator["CanJoints"]:
    """Yield the joints of a robot, after listening for two heartbeats; they are not checked.

    ``benches``: the simulated nodes that get the full motor model, each on a bench of its own.
    """
    from ...bus.can.joints import CanJoints, new_session
    from ...robot.file import load_can_robot
    from ...robot.poses import seated_pose_rad

    if simulated and (interface or channel):
        raise UserError("--interface and --channel: not with --sim, whose joints are in this process")
    data, can = load_can_robot(robot)
    if simulated and benches:
        from ...sim.motor.bench_port import BenchPort

        port: Port = BenchPort(data, benches)
    elif simulated:
        from ...sim.joints.sim_robot import SimRobot, sim_port

        robot_sim = SimRobot(data)
        port = sim_port(robot_sim)
    else:
        from ...bus.can.open import open_port

        port = open_port(can, interface, channel)
    pose_rad = seated_pose_rad(data)
    bus = CanJoints(data, port, new_session(), pose_rad, report=lambda notice: write_error(notice.sentence))
    try:
        bus.listen()
        yield bus
    finally:
        if simulated and not benches:
            robot_sim.close()
        port.close()
