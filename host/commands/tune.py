"""`caramelo tune`: searches better values for a robot file in the simulators, and writes a copy with them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, tell_written, write_error, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import ClusterAt, Jobs, Json, RobotName

if TYPE_CHECKING:
    from ..lab.tune.run import Tuning

WORLDS = {"plane": "plane", "space": "3-D"}
GOALS = ("speed", "steps", "payload", "quiet")
FOR_HELP = "What to improve: speed, steps (higher ones), payload (more, with less torque), quiet."
OUT_HELP = "Write the copy here (default: ROBOT-GOAL.toml in this folder)."
STORE_HELP = "Keep the trials here, and go on from them (default: beside the copy)."


def tune(
    robot: RobotName = "caramelo",
    goal: Annotated[str, typer.Option("--for", metavar="GOAL", help=FOR_HELP)] = "speed",
    trials: Annotated[int, typer.Option(min=2, max=100_000, help="Choices of values to try, eight walks each.")] = 200,
    gait: Annotated[str | None, typer.Option(help="A gait's name (default: the robot file's).")] = None,
    where: Annotated[str, typer.Option("--in", metavar="WORLD", help="plane, or space (MuJoCo).")] = "space",
    jobs: Jobs = 1,
    cluster: ClusterAt = "",
    out: Annotated[Path | None, typer.Option(metavar="FILE", help=OUT_HELP)] = None,
    store: Annotated[Path | None, typer.Option(metavar="FILE", help=STORE_HELP)] = None,
    as_json: Json = False,
) -> int:
    """Search the best values of a robot file for a goal and write a copy of the file with them, marked tuned.

    The robot walks each choice on several grounds, each with other friction, delay, voltage and drives. Then before and
    after are compared on grounds that the search did not use. Ctrl-C keeps the best so far; the same command goes on
    from there. Exit code 0 if the copy is better on those grounds; else 1, and no copy is written.

    Examples: caramelo tune --robot my.toml --for steps; caramelo tune --robot solo12 --for speed --jobs 4 --trials 400
    """
    from ..lab.tune.run import Tuning, Wanted
    from ..lab.tune.values import RobotFile
    from ..lab.workers.work import workers
    from ..robot.gait_names import gait_index
    from ..util.files import check_file
    from ..util.progress import cases

    for flag, value, allowed in (("--for", goal, GOALS), ("--in", where, WORLDS)):
        if value not in allowed:
            raise UserError(f"{flag} {value}: allowed {', '.join(allowed)}")
    file = RobotFile(robot)
    wanted = Wanted(file, goal, gait or file.robot.gait.default, WORLDS[where], trials)
    gait_index(file.robot, wanted.gait)
    copy = out or Path(f"{file.path.stem}-{goal}.toml")
    kept = store or copy.with_suffix(".trials.jsonl")
    check_file("--out", copy)
    if copy.exists() and not kept.exists():
        raise UserError(f"--out {copy}: the file exists and comes from no search in {kept}: name another")
    with workers(jobs, cluster) as run_by, cases(f"tuning {file.robot.name} for {goal}") as tell:
        tuning = Tuning(wanted, kept, run_by,
                        lambda done, best: tell(done, trials, "" if best is None else f"best {best:.4g}"))
        try:
            tuning.search()
        except KeyboardInterrupt:
            _keep(tuning, copy)
            raise
        tell(trials, trials, "the best few walk again")
        tuning.final()
        tell(trials, trials, "before and after on other grounds")
        other = tuning.on_other_grounds()
    result = tuning.result(other)
    better = other[1] > other[0]
    if better:
        tuning.write(copy)
    shown = result | {"ok": better, "file": str(copy) if better else None, "store": str(kept)}
    write_json(shown) if as_json else _show(shown)
    return 0 if better else NOT_ACHIEVED


def _keep(tuning: "Tuning", copy: Path) -> None:
    """Write the best so far of a search that was stopped, if there is any."""
    if len(tuning.store.trials) > 1:
        tuning.write(copy)
        write_error(f"the best of {len(tuning.store.trials)} trials so far is in {copy}, not compared on other grounds "
                    "yet; the same command goes on from there")


def _show(result: dict[str, Any]) -> None:
    """Print the values and the scores."""
    rows = [(key, f"{value['before']:.4g}", f"{value['after']:.4g}") for key, value in result["values"].items()]
    for title, key in (("score, searched grounds", "searched"), ("score, other grounds", "other_grounds")):
        before, after = (f"{result[key][when]:.4g}" for when in ("before", "after"))
        rows.append((f"{title}, {result['unit']}", before, after))
    print_table((f"{result['robot']} for {result['for']}, {result['trials']} trials", "before", "after"), rows)
    if result["ok"]:
        tell_written([result["file"]])
    else:
        write_error("the best is not better on grounds that the search did not use: no file written")
