"""`caramelo flash --can`: firmware for the joints of a robot over their bus."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from ..util.console import screen, write_error, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.progress import stages

if TYPE_CHECKING:
    from ..boards.flash.over_can import CanFlash, JointOutcome

Bus = tuple[str, str | None, str | None]  # robot, interface, channel


def flash_over_can(image: Path, nodes: list[int], every: bool, dry_run: bool, where: Bus, as_json: bool) -> int:
    """Flash joints with an image; exit code 1 if one of them does not run it at the end."""
    import secrets

    from ..boards.build.image_file import read_image_file
    from ..boards.flash.over_can import CanFlash, check_image
    from ..bus.can.open import open_port
    from ..bus.can.update_bus import UpdateBus
    from ..robot.file import load_can_robot

    wanted = _wanted(nodes, every)
    data = read_image_file(image)
    check_image(data)
    robot, interface, channel = where
    _, bus = load_can_robot(robot)
    with open_port(bus, interface, channel) as port, stages("flash", as_json) as tell:
        work = CanFlash(UpdateBus(port, secrets.randbelow(256)), data, wanted, tell)
        joints = list(work.survey().values())
        if not dry_run:
            joints = work.run()
    failed = [joint for joint in joints if joint.failure]
    if as_json:
        write_json({"build": data.about.build, "dry_run": dry_run, "joints": [asdict(joint) for joint in joints]})
    else:
        _print(work, joints, dry_run)
    for joint in failed:
        write_error(joint.failure)
    return NOT_ACHIEVED if failed else 0


def _wanted(nodes: list[int], every: bool) -> list[int]:
    """Return the joints to flash; UserError if the command does not name them clearly."""
    if bool(nodes) == every:
        raise UserError("flash --can: name the joints by number, 1 to 12, or all with --all")
    wrong = [node for node in nodes if not 1 <= node <= 12]
    if wrong:
        raise UserError(f"flash --can {wrong[0]}: allowed 1 to 12: FR hip 1, thigh 2, calf 3, then FL, RR, RL")
    return sorted(set(nodes)) or list(range(1, 13))


def _print(work: "CanFlash", joints: "list[JointOutcome]", dry_run: bool) -> None:
    console = screen()
    console.soft_wrap = True
    todo = work.waiting() if dry_run else []
    for joint in joints:
        if not joint.failure:
            console.print(f"{joint.joint}: {_line(joint, joint.node in todo, dry_run)}")


def _line(joint: "JointOutcome", waits: bool, dry_run: bool) -> str:
    runs = f"build {joint.build}, version {joint.version}, protocol {joint.protocol:#06x}, slot {joint.slot}"
    note = f"; {joint.note}" if joint.note else ""
    if dry_run:
        return f"runs {runs}; {'would be flashed' if waits else 'nothing to do'}{note}"
    if not joint.changed:
        return f"nothing to do: runs {runs}"
    return f"runs {runs}, confirmed{note}"
