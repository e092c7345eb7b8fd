"""`caramelo calibrate`: asks questions to find which servo is which joint, and where its zero is."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import screen
from ._options import RobotName

if TYPE_CHECKING:
    from ..bus.dynamixel.calibration.bench import Bench
    from ..robot.model import Robot


def calibrate(
    robot: RobotName = "caramelo",
    port: Annotated[str | None, typer.Option(help="Serial port (default: the robot file's).")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="File to write (default: the robot's own).")] = None,
    answers: Annotated[Path | None, typer.Option(metavar="FILE", help="Take the answers from a file.")] = None,
    record: Annotated[Path | None, typer.Option(metavar="FILE", help="Write each answer to a file.")] = None,
    preview: Annotated[bool, typer.Option("--preview", help="Show the change; leave the file as it is.")] = False,
    sim: Annotated[bool, typer.Option("--sim", help="Practise on emulated servos, mounted at random.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="How the emulated servos are mounted.")] = 0,
) -> int:
    """Calibrate the servos one by one. Put the robot on a stand, its feet in the air.

    Ctrl-C stops; the same command goes on from there, because a file beside the calibration keeps what is done, also
    with --preview. An existing calibration is kept as a backup. Exit code 1 if a leg does not end as drawn.

    Examples: caramelo calibrate; caramelo calibrate --sim --preview; caramelo calibrate --answers answers.toml
    """
    from ..bus.dynamixel.calibration.data import default_path, save_calibration, servo_of
    from ..bus.dynamixel.calibration.person import AtTerminal, FromFile, read_answers, write_answers
    from ..bus.dynamixel.calibration.procedure import Procedure, complain_about, difference
    from ..robot.file import load_robot
    from ..util.files import check_file

    data = load_robot(robot)
    servo_of(data)
    path = out or (Path("out/calibrate") / f"{data.name}.calibration.toml" if sim else default_path(data))
    check_file("--out", path)
    person: AtTerminal | FromFile = AtTerminal(record)
    recorded = dict(person.answers)
    if answers is not None:
        person = FromFile(read_answers(answers), str(answers), not sim)
    wrong: list[str] = []
    with _bench(data, port, sim, seed) as bench:
        procedure = Procedure(data, bench, person, path.with_name(path.name + ".unfinished"))
        found = procedure.run()
        change = difference(path, found)
        screen().print(change or f"{path}: nothing changes", soft_wrap=True)
        wanted = not change or (not preview and person.ask("write", f"Write {path}?", ["yes", "no"]) == "yes")
        if wanted:
            kept = save_calibration(path, found)
            if change:
                screen().print(f"wrote {path}" + (f"; the former one is {kept}" if kept else ""), soft_wrap=True)
            procedure.keep.unlink(missing_ok=True)
            wrong = procedure.check_legs(found)
        else:
            screen().print(f"nothing written; {procedure.keep} keeps the results so far", soft_wrap=True)
    if record is not None and answers is not None:
        write_answers(record, recorded | person.answers)
    if wrong:
        raise complain_about(wrong, found)
    return 0


@contextmanager
def _bench(robot: "Robot", port: str | None, sim: bool, seed: int) -> Iterator["Bench"]:
    """Yield the servos on their bench, real or emulated."""
    import time

    from ..bus.dynamixel.calibration.bench import Bench
    from ..bus.dynamixel.link import open_link
    from ..bus.dynamixel.table import TORQUE_ENABLE
    from ..sim.servos.stand import SimulatedBench, hidden_mounting

    if sim:
        yield SimulatedBench(robot, hidden_mounting(robot, seed))
        return
    with open_link(robot, port) as link:
        try:
            yield Bench(link, time.sleep)
        finally:
            link.broadcast(TORQUE_ENABLE, 0)
