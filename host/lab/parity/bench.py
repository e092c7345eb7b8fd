"""Everything `caramelo bench` prints, as data: cost per function and runtime, accuracy, the simulator's speed."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from ...boards.runtimes import Compiled, CortexM, CPython, Runtime, Unix, Wasi
from ...util.extras import missing_library
from ...util.progress import Tell
from .accuracy import Accuracy, accuracies
from .budget import WALK, over_budget, read_budget
from .figures import float_microseconds, fuel, instructions, loop_microseconds, microseconds
from .paths_fuel import path_fuel
from .sources import gather

REPEATS = 50  # calls in a timed loop
LOOP_TURNS = 1000  # of the loop whose time tells how fast the machine is
UNIX = ("bytecode", "native", "viper")

# What the figures have to reach. A time depends on the machine, so it is told and judged by the reader.
TICK_US = 60.0
FASTER_THAN_FLOATS = 3.0
COMPARED = ("leg.leg_inverse", "joint.current_step", WALK)
INSTRUCTIONS_MOST = {"joint.current_step": 777}  # of a Cortex-M4 as viper: 2 more than it takes


@dataclass
class Bench:
    """``cost`` holds a row of figures by function; ``skipped`` says which runtime is missing and why.

    ``loop_us``: LOOP_TURNS turns of ``x = x * 3 + i & 0xFFFF`` on CPython, to compare machines by.
    """

    cost: dict[str, dict[str, float]] = field(default_factory=dict)
    accuracy: list[Accuracy] = field(default_factory=list)
    simulator: dict[str, Any] = field(default_factory=dict)
    instructions: dict[str, int] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    over: list[str] = field(default_factory=list)
    loop_us: float = 0.0

    def fill(self, column: str, figures: dict[str, float] | dict[str, int]) -> None:
        for name, figure in figures.items():
            self.cost.setdefault(name, {})[column] = figure

    def ticks(self, column: str) -> dict[str, float]:
        """Return the microseconds of whole ticks by walk: of ``cpython_us`` or ``compiled_us``."""
        return {
            name.removeprefix(WALK): row[column]
            for name, row in self.cost.items()
            if name.startswith(WALK) and column in row
        }

    @property
    def missed(self) -> list[str]:
        """Return one sentence for each figure that does not reach what it has to."""
        found = [f"{a.name}: {a.worst:.4g} {a.unit}, at most {a.bar:g}" for a in self.accuracy if not a.ok]
        for name, row in self.cost.items():
            if name.startswith(COMPARED) and row.get("float_ratio", FASTER_THAN_FLOATS) < FASTER_THAN_FLOATS:
                found.append(f"{name}: {row['float_ratio']:.1f} x faster than floats, at least {FASTER_THAN_FLOATS:g}")
        for name, most in INSTRUCTIONS_MOST.items():
            if self.instructions.get(name, 0) > most:
                found.append(f"{name}: {self.instructions[name]} instructions of a Cortex-M4, at most {most}")
        return found + self.over


def run_bench(work: Path, simulate: bool, tell: Tell) -> Bench:
    """Measure everything that is installed here; ``tell`` hears what comes next."""
    bench = Bench()
    sources = gather(work)
    steps: list[tuple[str, Callable[[], object]]] = [
        ("loop", lambda: setattr(bench, "loop_us", loop_microseconds(sources, _new(work, "loop"), LOOP_TURNS))),
        ("cpython", lambda: bench.fill("cpython_us", microseconds(CPython(), sources, _new(work, "cpython"), REPEATS))),
        ("compiled", lambda: _time(bench, "compiled_us", Compiled(), sources, work)),
        ("fuel", lambda: _fuel(bench, sources, _new(work, "wasi"))),
        *((f"unix-{emitter}", partial(_unix, bench, sources, work, emitter)) for emitter in UNIX),
        ("instructions", lambda: _instructions(bench, sources, _new(work, "cortex-m"))),
        ("accuracy", lambda: bench.accuracy.extend(accuracies())),
    ]
    if simulate:
        steps.append(("simulator", lambda: _simulator(bench)))
    for number, (name, step) in enumerate(steps, 1):
        tell(number, len(steps), name)
        step()
    return bench


def _simulator(bench: Bench) -> None:
    try:
        bench.simulator.update(simulator_figures())
    except ModuleNotFoundError as error:  # a Raspberry Pi runs the bench without it
        missing = missing_library(error)
        if missing is None:
            raise
        bench.skipped["simulator"] = str(missing)


def simulator_figures() -> dict[str, Any]:
    """Return how fast the simulator walks Caramelo over flat ground, against real time."""
    from ...robot.file import load_robot
    from ...sim.walk import WalkSpec, run_walk, walk_result

    robot = load_robot("caramelo")
    spec = WalkSpec(robot=robot, gait=robot.gait.default, distance_m=0.5)
    result = walk_result(spec, run_walk(spec))
    return {key: result[key] for key in ("robot", "gait", "terrain", "duration_s", "real_time_factor")}


def _fuel(bench: Bench, sources: Path, work: Path) -> None:
    missing = Wasi().missing()
    if missing:
        bench.skipped["wasi"] = missing
        return
    burnt = fuel(sources, work) | path_fuel(work)
    bench.fill("fuel", burnt)
    bench.over = over_budget(burnt, read_budget())


def _instructions(bench: Bench, sources: Path, work: Path) -> None:
    runtime = CortexM(counting=True)
    missing = runtime.missing()
    if missing:
        bench.skipped[runtime.name] = missing
        return
    bench.instructions.update(instructions(runtime, sources, work))


def _time(bench: Bench, column: str, runtime: Runtime, sources: Path, work: Path) -> bool:
    """Fill a column with microseconds; return False if the runtime is missing."""
    missing = runtime.missing()
    if missing:
        bench.skipped[runtime.name] = missing
        return False
    bench.fill(column, microseconds(runtime, sources, _new(work, runtime.name), REPEATS))
    return True


def _unix(bench: Bench, sources: Path, work: Path, emitter: str) -> None:
    runtime = Unix(emitter)
    if _time(bench, f"{emitter}_us", runtime, sources, work) and emitter == "viper":
        floats = float_microseconds(runtime, sources, _new(work, "floats"), REPEATS)
        bench.fill("float_us", {name: us for name, us in floats.items() if name in bench.cost})
        for row in bench.cost.values():
            if "float_us" in row and row["viper_us"] > 0:
                row["float_ratio"] = row["float_us"] / row["viper_us"]


def _new(work: Path, name: str) -> Path:
    folder = work / name
    folder.mkdir()
    return folder
