"""`caramelo motor`: runs a brushless joint's firmware over a motor model, and a real board's self-test."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import print_table, tell_written, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.progress import cases
from ._options import Json

if TYPE_CHECKING:
    from ..robot.actuators import Bldc
    from ..sim.motor.result import Result

GROUP = typer.Typer(help="Simulate a brushless joint with its own firmware, or test its board.", no_args_is_help=True)

RobotOption = Annotated[str, typer.Option(help="A robot with brushless joints: its name, or a file ending in .toml.")]


@GROUP.command("sim")
def sim(
    scenario: Annotated[
        str | None,
        typer.Option(
            help="step, sine, glitches, stall, current-locked, current-held, closed-loop, commission, or fault-NAME."
        ),
    ] = None,
    robot: RobotOption = "parallel",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write a picture of each scenario here.")] = None,
    as_json: Json = False,
) -> int:
    """Run the joint's firmware on a simulated board and motor. Without --scenario: all scenarios, and accuracy.

    Faults: shunt-offset, lost-encoder, encoder-disagreement, open-thermistor, short-thermistor, bus-sag, stall,
    late-interrupt, swapped-phases. Exit code 1 if a figure is missed.

    Examples: caramelo motor sim; caramelo motor sim --scenario step --out out/motor;
    caramelo motor sim --scenario fault-bus-sag --json
    """
    from ..sim.motor.scenarios import chosen, run_scenario
    from ..util.files import check_folder

    check_folder("--out", out)
    bldc = _joint_of(robot)
    wanted = chosen(scenario)
    results: list[Result] = []
    with cases("simulated joint") as tell:
        for number, name in enumerate(wanted, 1):
            tell(number, len(wanted), name)
            results.append(run_scenario(bldc, name))
    figures = {result.name: result.figures for result in results}
    if scenario is None:
        from ..lab.motor_accuracy import accuracy

        figures["accuracy"] = accuracy(bldc)
    written = _draw(results, out) if out else []
    ok = all(row["ok"] for row in figures.values())
    if as_json:
        write_json(figures[scenario] if scenario else {"ok": ok, "scenarios": figures})
    else:
        rows = [("" if i else name, key, value)
                for name, row in figures.items() for i, (key, value) in enumerate(row.items())]
        print_table(("scenario", "figure", "value"), rows, 80)
        tell_written(written)
    return 0 if ok else NOT_ACHIEVED


@GROUP.command("selftest")
def selftest(
    port: Annotated[str, typer.Option(help="Serial device of the joint's board, such as /dev/ttyACM0.")],
    bridge: Annotated[
        bool,
        typer.Option(
            "--bridge",
            help="Also switch all three phases at half the period for 0.2 s. Connect the supply, limited to 0.2 A, and "
            "USB. Do not connect the motor unless the test without --bridge has passed and the joint is free to "
            "turn.",
        ),
    ] = False,
    as_json: Json = False,
) -> int:
    """Measure on a real joint's board what no simulation can show. Without --bridge the bridge stays off.

    Measures the times of the control interrupt and the current step, ADC noise, gate driver and encoders. Exit code 1
    if one is outside its limits.

    Example: caramelo motor selftest --port /dev/ttyACM0
    """
    from ..boards.joint_selftest import ask, judge

    rows = judge(ask(port, bridge))
    ok = all(row.ok for row in rows)
    if as_json:
        write_json({"ok": ok, "figures": [vars(row) for row in rows]})
    else:
        from rich.text import Text

        print_table(("figure", "found", "allowed", ""), [
            (row.name, row.found, row.allowed, "ok" if row.ok else Text("outside", style="red")) for row in rows], 90)
    return 0 if ok else NOT_ACHIEVED


def _joint_of(robot: str) -> "Bldc":
    from ..robot.actuators import Bldc
    from ..robot.file import load_robot

    data = load_robot(robot)
    if not isinstance(data.actuator, Bldc):
        raise UserError(f"--robot {robot}: its joints are not brushless; name a robot with actuator.kind = bldc")
    return data.actuator


def _draw(results: "list[Result]", out: Path) -> list[Path]:
    from ..sim.motor.plots import draw

    paths = []
    for result in results:
        paths.append(out / f"{result.name}.png")
        draw(result, paths[-1])
    return paths
