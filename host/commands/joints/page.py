"""`caramelo joints page`: one joint's parameters, signals and steps in a browser."""

from typing import Annotated

import typer

from ...util.console import screen
from ...util.errors import NOT_ACHIEVED
from .options import Channel, Interface, RobotName, Seconds, Sim, joints


def page(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    listen: Annotated[str, typer.Option(metavar="ADDR", help="Address, or address:port.")] = "127.0.0.1:8080",
    seconds: Seconds = None,
) -> int:  # fmt: skip
    """Serve a page for the joints: parameters with their limits, plots of what you pick, steps of one joint's goal.

    Put the robot on a stand before you arm it on the page. Space, the red button and closing the page that armed it
    all stop. Ctrl-C ends the command. Exit code 1 if the page's process ends by itself.

    Example: caramelo joints page --sim
    """
    import time

    from ...robot.file import find
    from ...teleop.joint_page import JointPage, about
    from ...teleop.side import PAGE, SideProcess, listen_address
    from ...teleop.web.access import is_loopback, new_code
    from ...teleop.web.paired import paired_path

    where, code, console = listen_address(listen), new_code(), screen()
    with joints(robot, interface, channel, sim) as bus:
        setup = {
            "robot": str(find(robot)), "code": code, "about": about(bus.robot, sim), "first": "joints.html",
            "paired": str(paired_path()),
        }  # fmt: skip
        server, served = SideProcess(PAGE, where, setup), JointPage(bus)
        try:
            server.start(served.hub)
            server.wait(served.hub, served.tick)
            who = " (other users of this machine need it)" if is_loopback(where[0]) else ""
            console.print(f"{server.note}, pairing code {code}{who}; Ctrl-C ends", soft_wrap=True)
            end_s = None if seconds is None else time.monotonic() + seconds
            while served.hub.has_side(PAGE.source) and (end_s is None or time.monotonic() < end_s):
                served.tick()
            lost = not served.hub.has_side(PAGE.source)
        except KeyboardInterrupt:
            lost = False
        finally:
            served.close()
            server.close()
    console.print("the page's process ended by itself; the joints are off" if lost else "ended; the joints are off")
    return NOT_ACHIEVED if lost else 0
