"""`caramelo joints sim`: simulates the robot's joints on a bus, without hardware."""

from contextlib import closing
from typing import Annotated

import typer

from ...util.console import screen
from .options import RobotName, Seconds


def sim(
    robot: RobotName = "parallel",
    interface: Annotated[str, typer.Option(help="udp_multicast, or socketcan with a vcan channel.")] = "udp_multicast",
    channel: Annotated[str, typer.Option(help="default is python-can's own group; two: with a comma.")] = "default",
    fault: Annotated[list[str] | None, typer.Option(help="KIND[:NODE]@SECONDS, such as power-cycle:5@10.")] = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of frames that each node misses.")] = 0.0,
    vm: Annotated[int, typer.Option(min=0, max=12, help="How many joints run in MicroPython VMs of their own.")] = 0,
    seconds: Seconds = None,
) -> int:
    """Simulate the robot's twelve joints on a bus: each runs its own firmware, and the body moves in the plane.

    Then, in another terminal: caramelo joints status --interface udp_multicast --channel default

    Examples: caramelo joints sim --fault power-cycle:5@10 --loss 0.01; caramelo joints sim --vm 4
    """
    from ...bus.can.open import open_port
    from ...bus.can.pair import PairPort
    from ...robot.file import load_can_robot
    from ...sim.joints.gateway import Gateway
    from ...sim.joints.sim_robot import SimRobot

    data, bus = load_can_robot(robot)
    bus = bus.model_copy(update={"interface": interface, "channel": channel})
    data = data.model_copy(update={"bus": bus})
    with open_port(bus) as port, closing(SimRobot(data, in_vm=range(1, 1 + vm))) as robot_sim:
        gateway = Gateway(robot_sim, *(port.ports if isinstance(port, PairPort) else (port,)))
        for node in robot_sim.nodes:
            node.loss = loss
        for one in fault or ():
            gateway.inject(one)
        screen().print(f"twelve joints on {port.name}; Ctrl-C ends them")
        try:
            gateway.run(seconds)
        except KeyboardInterrupt:
            screen().print("stopped")
    if gateway.behind_s:
        screen().print(f"this machine was too slow: it fell {gateway.behind_s:.1f} s behind in all")
    return 0
