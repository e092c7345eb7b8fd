"""`caramelo joints sim`: the robot's joints on a bus, without hardware."""

from typing import Annotated

import typer

from ...console import screen
from .options import RobotName, Seconds


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
    from ...can.adapter import AdapterPort
    from ...joints.gateway import Gateway
    from ...joints.sim_robot import SimRobot
    from ...robot_file import load_robot

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
