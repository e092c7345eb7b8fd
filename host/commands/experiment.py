"""`caramelo experiment`: repeats the papers' experiments in the simulators, beside the papers' figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import screen, tell_written, write_error, write_json
from ..util.errors import UserError
from ._options import ClusterAt, Honest, Jobs, Json, RobotName

if TYPE_CHECKING:
    from ..lab.experiments.case import Table as Rows

WHAT_HELP = ("table1, table2, ramp, steps, payload, requirements, or all of them; goals, the figures to reach; "
             "or drawn, robots drawn at random.")

SETS = ("chosen", "held-out")
SET_HELP = "Seeds and start offsets: chosen, used to find the constants, or held-out, used only to check them."


def experiment(
    what: Annotated[str, typer.Argument(metavar="EXPERIMENT", help=WHAT_HELP)],
    robot: RobotName = "caramelo",
    gait: Annotated[str | None, typer.Option(help="A gait's name or file (default: the robot file's).")] = None,
    trials: Annotated[int | None, typer.Option(min=1, max=1000, help="Trials per case (default: its own).")] = None,
    jobs: Jobs = 1,
    cluster: ClusterAt = "",
    only: Annotated[str, typer.Option(metavar="GROUPS", help="With goals: these groups only, comma-separated.")] = "",
    which: Annotated[str, typer.Option("--set", metavar="SET", help=SET_HELP)] = "chosen",
    three_d: Annotated[bool, typer.Option("--3d/--no-3d", help="Also check in three dimensions.")] = True,
    honest: Honest = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write report.html, PNG and JSON files here.")] = None,
    as_json: Json = False,
) -> None:
    """Run one of the papers' experiments, or all, and print its figures beside the papers'.

    The same trials give the same figures on every machine. Exit code 0 if it ran, whatever the figures are.

    Examples: caramelo experiment table1; caramelo experiment steps --gait paper-trot --jobs 4 --out out/steps;
    caramelo experiment all --trials 3 --jobs 4 --json; caramelo experiment goals --robot parallel --only flat,steps
    """
    from ..lab.experiments.run import names_of, run_experiment, write_outcomes
    from ..lab.experiments.trials import Options, space_is_there
    from ..lab.workers.work import workers
    from ..robot.file import load_robot
    from ..robot.gait_file import with_gait
    from ..robot.trot_tuning import GAIT
    from ..util.extras import how_to_get
    from ..util.files import check_folder
    from ..util.progress import cases

    check_folder("--out", out)
    names = names_of(what)
    data = with_gait(load_robot(robot).simulated(honest), gait or (GAIT if what == "goals" else None))
    chosen = data.gait.default
    if which not in SETS:
        raise UserError(f"--set {which}: allowed {' or '.join(SETS)}")
    if only and what != "goals":
        raise UserError(f"--only {only}: only with experiment goals; {what} has no groups")
    if what == "drawn" and robot != "caramelo":
        raise UserError(f"--robot {robot}: not with experiment drawn, which draws its robots")
    in_space = three_d and space_is_there()
    if three_d and not in_space:
        write_error(f"MuJoCo is not installed, so the 3-D columns stay empty: {how_to_get('mujoco')}")
    groups = tuple(filter(None, only.split(",")))
    options = Options(data, chosen, trials, in_space, which == "held-out", groups)
    outcomes = []
    with workers(jobs, cluster) as run_by:
        for name in names:
            with cases(f"{name} ({chosen})") as tell:
                outcomes.append(run_experiment(name, options, run_by, tell))
            if not as_json:
                show_tables(outcomes[-1].found.tables)
    written = write_outcomes(options, outcomes, out) if out else []
    if as_json:
        write_json(outcomes[0].found.result if what != "all" else {o.name: o.found.result for o in outcomes})
    else:
        tell_written(written)


def show_tables(tables: "list[Rows]") -> None:
    """Print an experiment's tables."""
    from rich.table import Table
    from rich.text import Text

    console = screen()
    for table in tables:
        shown = Table(title=table.title, title_justify="left", box=None, padding=(0, 2, 0, 0))
        for column in table.head:
            shown.add_column(column, overflow="fold")
        for row in table.rows:
            shown.add_row(*map(Text, row))
        console.print(shown)
        console.print()
