"""`caramelo bench`: how long the core takes in every runtime here, how exact it is, how fast the simulator runs."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, screen, write_json
from ..util.errors import NOT_ACHIEVED
from ._options import Json

if TYPE_CHECKING:
    from ..lab.parity.bench import Bench

Simulator = Annotated[bool, typer.Option(help="Also time the simulator.")]
Teleop = Annotated[bool, typer.Option("--teleop", help="Measure teleoperation instead, from outside.")]
Seconds = Annotated[float, typer.Option(min=1.0, max=3600.0, metavar="S", help="With --teleop: how long to walk.")]
Presses = Annotated[int, typer.Option(min=3, max=1000, metavar="N", help="With --teleop: sticks and stops per source.")]
Update = Annotated[bool, typer.Option("--update-budget", help="Make today's costs the budget.")]

COLUMNS = ("cpython_us", "compiled_us", "fuel", "bytecode_us", "native_us", "viper_us", "float_us", "float_ratio")
TELEOP_WIDTH = 150
WIDTH = 130  # characters, so that a table is not cut where the output is no terminal
HEADS = ("CPython us", "compiled us", "fuel", "bytecode us", "native us", "viper us", "floats us", "floats/viper")


def bench(
    simulator: Simulator = True,
    update_budget: Update = False,
    teleop: Teleop = False,
    seconds: Seconds = 30.0,
    presses: Presses = 100,
    as_json: Json = False,
) -> int:
    """Measure the core: each function's time in each runtime, exact cost and accuracy; and the simulator's speed.

    Fuel is the WASI VM's count of instructions, the same in every run. Exit code 1 if it is more than 5 % over the
    budget in the repository, or if a figure misses its bar. CPython's times are processor time, of the core's sources
    and of the compiled core (caramelo core build; without it the bench compiles its own, which takes a minute).
    Bytecode, native, viper and floats run in one VM, MicroPython's unix port.

    --teleop measures the deadlines and processor share of a walk, the times from stick to packet and from stop to
    torque off for every source, and the effect of bad messages; through a browser if there is one. Exit code 1 if a
    figure is not reached.

    Examples: caramelo bench; caramelo bench --json; caramelo bench --teleop
    """
    if teleop:
        return _teleop(seconds, presses, as_json)
    import tempfile
    from pathlib import Path

    from ..lab.parity.bench import run_bench
    from ..lab.parity.budget import write_budget
    from ..util.progress import cases

    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder, cases("bench") as tell:
        found = run_bench(Path(folder), simulator, tell)
    burnt = {name: int(row["fuel"]) for name, row in found.cost.items() if "fuel" in row}
    if update_budget and burnt:
        write_budget(burnt)
        found.over = []
    if as_json:
        write_json(_summary(found))
    else:
        _print(found)
    return NOT_ACHIEVED if found.missed else 0


def _teleop(seconds: float, presses: int, as_json: bool) -> int:
    from rich.text import Text

    from ..lab.teleop.bench import run_bench
    from ..util.progress import write_step

    found = run_bench(seconds, presses, write_step)
    if as_json:
        write_json(found.as_dict())
    else:
        rows = [(Text(row.what, style="" if row.reached else "red"), f"{row.value:g}", f"{row.at_most:g}", row.unit,
                 row.detail) for row in found.rows]
        print_table(("figure", "measured", "at most", "", ""), rows, TELEOP_WIDTH)
        console = screen()
        for name, reason in found.skipped.items():
            console.print(f"{name}: skipped: {reason}", soft_wrap=True)
    return 0 if all(row.reached for row in found.rows) else NOT_ACHIEVED


def _summary(found: "Bench") -> dict[str, Any]:
    return {
        "cost": found.cost,
        "accuracy": [
            {"name": a.name, "unit": a.unit, "worst": a.worst, "median": a.median, "bar": a.bar, "cmsis_worst": a.cmsis}
            for a in found.accuracy
        ],
        "tick_us": found.ticks("cpython_us"),
        "compiled_tick_us": found.ticks("compiled_us"),
        "cortex_m4_instructions": found.instructions,
        "loop_us": found.loop_us,
        "simulator": found.simulator,
        "skipped": found.skipped,
        "missed": found.missed,
    }


def _print(found: "Bench") -> None:
    from ..lab.parity.bench import LOOP_TURNS, TICK_US

    console = screen()
    rows = [(name, *(_cell(column, row.get(column)) for column in COLUMNS)) for name, row in found.cost.items()]
    print_table(("function", *HEADS), rows, WIDTH)
    console.print()
    print_table(("error of", "worst", "median", "at most", "CMSIS-DSP q15", ""), [
        (a.name, f"{a.worst:.2g}", f"{a.median:.2g}", f"{a.bar:g}", "" if a.cmsis is None else f"{a.cmsis:.3g}", a.unit)
        for a in found.accuracy])
    console.print(f"\nwhole tick, us (at most {TICK_US:g} wanted)")
    for title, column in (("CPython", "cpython_us"), ("CPython, compiled", "compiled_us")):
        ticks = ", ".join(f"{walk} {us:.0f}" for walk, us in found.ticks(column).items())
        if ticks:
            console.print(f"{title}: {ticks}", soft_wrap=True)
    if found.instructions:
        counts = ", ".join(f"{name} {count}" for name, count in found.instructions.items())
        console.print(f"instructions on a Cortex-M4 as viper, with the call: {counts}", soft_wrap=True)
    console.print(
        f"this machine: {LOOP_TURNS} turns of x = x * 3 + i & 0xFFFF take {found.loop_us:.0f} us on CPython",
        soft_wrap=True,
    )
    if found.simulator:
        row = found.simulator
        console.print(
            f"simulator: {row['robot']} walks {row['duration_s']:.1f} s ({row['gait']}, {row['terrain']} ground) "
            f"at {row['real_time_factor']:.1f} x real time"
        )
    for name, reason in found.skipped.items():
        console.print(f"{name}: skipped: {reason}", soft_wrap=True)
    for sentence in found.missed:
        console.print(sentence, style="red", soft_wrap=True)


def _cell(column: str, figure: float | None) -> str:
    if figure is None:
        return ""
    if column == "fuel":
        return str(int(figure))
    return f"{figure:.1f}" if column == "float_ratio" or figure >= 100 else f"{figure:.2f}"
