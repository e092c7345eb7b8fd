"""`caramelo export`: writes the robot as a MuJoCo model or a URDF, generated from its file."""

from pathlib import Path
from typing import Annotated

import typer

from ..util.console import say, tell_written, write_json
from ..util.errors import UserError
from ._options import RobotName

Out = Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write here instead of to the terminal.")]
Payload = Annotated[float, typer.Option(metavar="KG", min=0.0, max=20.0, help="Load on the body, kg.")]
Voltage = Annotated[float | None, typer.Option(metavar="V", help="Supply voltage, V (default: nominal).")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object: the file written and its size.")]
GROUND_HELP = "As for caramelo walk --in space."

GROUP = typer.Typer(help="Write the robot as a MuJoCo model or a URDF, from its file.", no_args_is_help=True)


@GROUP.command("mjcf")
def export_mjcf(
    robot: RobotName = "caramelo",
    out: Out = None,
    payload: Payload = 0.0,
    voltage: Voltage = None,
    friction: Annotated[float | None, typer.Option(min=0.05, max=2.0, help="Friction (default: the file's).")] = None,
    terrain: Annotated[str, typer.Option(metavar="NAME", help=GROUND_HELP)] = "flat",
    height: Annotated[float | None, typer.Option(metavar="M", help="Height of the step, box or stones, m.")] = None,
    angle: Annotated[float, typer.Option(metavar="DEG", help="Slope of the ramp, degrees.")] = 5.34,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Seed of the stones.")] = 0,
    as_json: Json = False,
) -> None:
    """Write the robot and its ground as a MuJoCo model, with the servo law as its actuators.

    Examples: caramelo export mjcf --out caramelo.xml; caramelo export mjcf --terrain step --height 0.04
    """
    from ..robot.file import load_robot
    from ..sim.export.mjcf import ModelOptions, mjcf
    from ..sim.grounds import GroundSpec, make_ground

    ground = make_ground(GroundSpec(terrain, height, angle, seed=seed))
    options = ModelOptions(ground, payload, friction, _checked_voltage(voltage, robot))
    _deliver(mjcf(load_robot(robot), options), "mjcf", robot, out, as_json)


@GROUP.command("urdf")
def export_urdf(
    robot: RobotName = "caramelo",
    out: Out = None,
    payload: Payload = 0.0,
    voltage: Voltage = None,
    as_json: Json = False,
) -> None:
    """Write the robot as a URDF with inertias, limits, efforts and speeds, for RViz and others.

    Examples: caramelo export urdf --out caramelo.urdf; caramelo export urdf --robot parallel
    """
    from ..robot.file import load_robot
    from ..robot.urdf import urdf

    _deliver(urdf(load_robot(robot), payload, _checked_voltage(voltage, robot)), "urdf", robot, out, as_json)


def _checked_voltage(voltage_V: float | None, robot: str) -> float | None:
    """Return the voltage if the robot file has the drives' data for it."""
    from ..robot.file import load_robot
    from ..robot.plane import planar_robot

    if voltage_V is not None:
        try:
            planar_robot(load_robot(robot)).thigh_servo.at_voltage(voltage_V)
        except ValueError as error:
            raise UserError(f"--voltage {voltage_V:g}: {error}") from error
    return voltage_V


def _deliver(text: str, kind: str, robot: str, out: Path | None, as_json: bool) -> None:
    """Write the model to its file or the terminal."""
    from ..util.files import write_text

    if as_json and out is None:
        raise UserError("--json: the model itself is not JSON; name its file with --out FILE")
    if out is None:
        say(text.removesuffix("\n"))
        return
    write_text(out, text)
    if as_json:
        write_json({"robot": robot, "format": kind, "file": str(out), "bytes": len(text.encode())})
    else:
        tell_written([out])
