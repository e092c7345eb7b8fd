"""`caramelo identify`: measures the robot's servos, and writes the numbers into a copy of its file."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, screen, tell_written, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.progress import stages
from ._options import ClusterAt, Jobs, RobotName

if TYPE_CHECKING:
    from ..bus.dynamixel.calibration.person import Person
    from ..identify.procedure import Result
    from ..identify.rig import Rig
    from ..robot.model import Robot
    from ..sim.servos.honest import HonestStand


def identify(
    robot: RobotName = "caramelo",
    port: Annotated[str | None, typer.Option(help="Serial port (default: the robot file's).")] = None,
    calibration: Annotated[Path | None, typer.Option(metavar="FILE", help="Default: the robot's own.")] = None,
    joint: Annotated[list[str] | None, typer.Option(metavar="NAME", help='Only this joint: "RL thigh".')] = None,
    fit: Annotated[Path | None, typer.Option(metavar="RECORDS", help="Fit recorded sweeps, without the robot.")] = None,
    jobs: Jobs = 1,
    cluster: ClusterAt = "",
    out: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Default: out/identify/ROBOT.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask; it is on its stand, then on the floor.")] = False,
    no_floor: Annotated[bool, typer.Option("--no-floor", help="Measure only on the stand.")] = False,
    sim: Annotated[bool, typer.Option("--sim", help="Measure emulated servos, drawn at random.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the emulated servos.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object; needs --yes, --sim or --fit.")] = False,
) -> int:
    """Measure the servos: first on a stand, one joint after the other; then on the floor, on the robot's own legs.

    Finds bus delay, stiffness, speed, torque, friction, play, rotor inertia and the sag of the supply; compares each
    joint with its counterparts on the other legs; writes pictures and a copy of the robot file. Ctrl-C lets go of all
    joints; the measurements are kept, and the same command goes on from there. Exit code 1 if a joint is not sound.

    Examples: caramelo identify; caramelo identify --sim; caramelo identify --fit out/identify/caramelo --jobs 4
    """
    from ..bus.dynamixel.calibration.data import servo_of
    from ..bus.dynamixel.calibration.person import AtTerminal, FromFile
    from ..identify.procedure import fit_all
    from ..lab.workers.work import workers
    from ..robot.file import find, load_robot

    data = load_robot(robot)
    servo_of(data)
    folder = fit or out or Path("out/identify") / (f"{data.name}-sim-{seed}" if sim else data.name)
    joints = _joints(joint)
    if as_json and not (yes or sim or fit):
        raise UserError("--json: can't ask questions: add --yes, --sim or --fit RECORDS")
    if cluster and not fit:
        raise UserError(f"--cluster {cluster}: only with --fit RECORDS: measure first, then fit what was recorded")
    if fit is None:
        agrees = FromFile({"stand": "go", "floor": "go"}, "--yes")
        person: Person = agrees if yes or sim else AtTerminal()
        with _rig(data, port, calibration, sim, seed) as (rig, stand):
            _measure(data, rig, stand, person, folder, joints, not no_floor and joint is None)
    with workers(jobs, cluster) as run_by, stages("fit", as_json) as show:
        result = fit_all(data, folder, show, run_by.run_all)
    pictures = _draw(data, folder, result)
    copy = _write_copy(data, find(robot), folder, result)
    _tell(result, as_json, [*pictures, *copy])
    return 0 if result.sound and copy else NOT_ACHIEVED


def _joints(names: list[str] | None) -> list[int]:
    from ..bus.base import JOINT_LABELS

    if not names:
        return list(range(len(JOINT_LABELS)))
    for name in names:
        if name not in JOINT_LABELS:
            raise UserError(f'--joint "{name}": allowed {", ".join(JOINT_LABELS)}')
    return [JOINT_LABELS.index(name) for name in names]


@contextmanager
def _rig(
    robot: "Robot", port: str | None, calibration: Path | None, sim: bool, seed: int
) -> Iterator[tuple["Rig", "HonestStand | None"]]:
    """Yield the servos, real or emulated; lets go of all at the end, whatever happens."""
    import time

    from ..bus.dynamixel.calibration.data import default_path, load_calibration, nominal
    from ..bus.dynamixel.link import open_link
    from ..identify.rig import Rig
    from ..robot.poses import rest_pose_rad

    if sim:
        from ..sim.servos.honest import HonestStand, drawn

        stand = HonestStand(robot, nominal(robot), drawn(robot, seed), rest_pose_rad(robot))
        yield stand.rig, stand
        return
    found = load_calibration(calibration or default_path(robot), robot)
    with open_link(robot, port) as link:
        rig = Rig(robot, found, link, time.monotonic, lambda until_s: time.sleep(max(0.0, until_s - time.monotonic())))
        try:
            yield rig, None
        finally:
            rig.close()


def _measure(
    robot: "Robot", rig: "Rig", stand: "HonestStand | None", person: "Person", folder: Path, joints: list[int],
    floor: bool,
) -> None:  # fmt: skip
    """Ask, and measure what is not measured yet: on the stand, then on the floor if nothing forbids it."""
    import mcap.writer  # noqa: F401  a library that is missing is told before anything moves

    from ..identify import keeping
    from ..identify.procedure import glance, measure_in_air, measure_on_ground, unsafe

    rig.prepare()
    person.say(
        "Put the robot on its stand: feet in the air, nothing within reach of the legs. Joints turn by up to 29 deg, "
        f"quickly, with half their torque, one after the other. Records go to {folder}."
    )
    if person.ask("stand", "Measure?", ["go", "no"]) == "no":
        raise UserError("nothing was measured", NOT_ACHIEVED)
    with stages("stand") as show:
        measure_in_air(rig, folder, joints, show)
    if not floor or keeping.together_path(folder, "ground").exists():
        return
    with stages("weights") as show:
        reasons = unsafe(glance(robot, folder, show))
    if reasons:
        person.say("The robot must not stand up: " + "; ".join(reasons))
        return
    person.say("Put the robot on the floor, legs folded under it. It stands up, sways for half a minute and sits down.")
    if person.ask("floor", "Stand up?", ["go", "no"]) == "go":
        if stand is not None:
            stand.put_on_ground()
        with stages("floor") as show:
            measure_on_ground(rig, folder, show)


def _draw(robot: "Robot", folder: Path, result: "Result") -> list[Path]:
    from ..bus.dynamixel.calibration.data import servo_of
    from ..identify import keeping
    from ..identify.carried import in_the_air
    from ..identify.picture import draw

    paths = []
    for joint, fitted in result.fits.items():
        path = keeping.path_of(folder, joint).with_suffix(".png")
        traces = keeping.kept_traces(keeping.path_of(folder, joint), robot)
        words = result.verdicts[joint].sentence.partition(": ")[2]
        draw(path, joint, servo_of(robot), in_the_air(robot, joint), traces, fitted, words)
        paths.append(path)
    return paths


def _write_copy(robot: "Robot", source: Path, folder: Path, result: "Result") -> list[Path]:
    """Write the copy of the robot file, unless too few joints are sound."""
    from datetime import date

    from ..bus.dynamixel.calibration.data import servo_of
    from ..identify.filing import copy_with
    from ..identify.procedure import measures

    found = measures(result)
    if not found:
        return []
    target = folder / f"{robot.name}.toml"
    copy_with(source, target, servo_of(robot), found, date.today())
    return [target]


def _tell(result: "Result", as_json: bool, paths: list[Path]) -> None:
    from ..bus.base import JOINT_LABELS

    if as_json:
        write_json({
            "joints": {
                JOINT_LABELS[joint]: {
                    "kind": verdict.kind, "verdict": verdict.sentence,
                    **(_figures(result, joint) if joint in result.fits else {}),
                }
                for joint, verdict in sorted(result.verdicts.items())
            },
            "supply_ohm": result.supply_ohm,
            "stood": result.stood,
            "sound": result.sound,
            "wrote": [str(path) for path in paths],
        })  # fmt: skip
        return
    head = ("joint", "stall N m", "rad/s", "duty/rad", "lag ms", "dry N m", "rest N m", "play deg", "delay ms")
    rows = [(JOINT_LABELS[j], *(f"{value:.3g}" for value in _row(result, j))) for j in sorted(result.fits)]
    print_table(head, rows)
    for _, verdict in sorted(result.verdicts.items()):
        screen().print(verdict.sentence, soft_wrap=True)
    if not result.stood:
        screen().print("not measured on the floor: torque and the load's share of friction are still the file's")
    tell_written(paths)


def _figures(result: "Result", joint: int) -> dict[str, Any]:
    fitted = result.fits[joint]
    return {
        **fitted.values, "delay_s": fitted.delay_s, "spread": fitted.spread, "misfit": fitted.misfit,
        "fits": fitted.fits,
    }  # fmt: skip


def _row(result: "Result", joint: int) -> tuple[float, ...]:
    from math import degrees

    from ..identify.model import lag_s

    v = result.fits[joint].values
    return (
        v["stall_Nm"], v["no_load_rad_s"], v["duty_per_rad"], 1000 * lag_s(v), v["coulomb_Nm"],
        v["coulomb_Nm"] + v["stribeck_Nm"], degrees(v["backlash_rad"]), 1000 * result.fits[joint].delay_s,
    )  # fmt: skip
