"""`caramelo walk`: lets a simulated robot walk over some ground and prints how it went."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, progress, screen, tell_written, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Honest, Json, RobotName

if TYPE_CHECKING:
    from sim2d.recording import Recording

    from ..sim.walk import WalkSpec

WORLDS = ("plane", "space")
FILES = ("walk.html", "walk.svg", "path.png", "walk.json")  # what --out gets
TERRAIN_HELP = (
    "flat, stones, gravel, ramp (up and down), slope-up, slope-down, step (up and down), step-up, step-down, box, "
    "stairs-up, stairs-down; in space also angled (a step met askew) and left (one under the left legs only)."
)


def walk(
    robot: RobotName = "caramelo",
    gait: Annotated[str | None, typer.Option(help="A gait's name or file (default: the robot file's).")] = None,
    speed: Annotated[float, typer.Option(metavar="M_S", help="Commanded speed, m/s.")] = 0.05,
    where: Annotated[str, typer.Option("--in", metavar="WORLD", help="plane, or space (MuJoCo).")] = "plane",
    terrain: Annotated[str, typer.Option(metavar="NAME", help=TERRAIN_HELP)] = "flat",
    height: Annotated[float | None, typer.Option(metavar="M", help="Height of step, box or stones, m.")] = None,
    angle: Annotated[float, typer.Option(metavar="DEG", help="Slope of the ramp, degrees.")] = 5.34,
    length: Annotated[float | None, typer.Option(metavar="M", help="Length of step, box, slope, tread, m.")] = None,
    start: Annotated[float, typer.Option(metavar="M", help="Where the obstacle begins, m ahead of the body.")] = 0.35,
    distance: Annotated[float, typer.Option(metavar="M", help="How far to walk, m.")] = 1.5,
    payload: Annotated[float, typer.Option(metavar="KG", help="Load on the body, kg.")] = 0.0,
    friction: Annotated[float, typer.Option(help="Friction between foot and ground.")] = 0.9,
    voltage: Annotated[float | None, typer.Option(metavar="V", help="Supply voltage, V.")] = None,
    bus_delay: Annotated[float, typer.Option(metavar="S", help="How late goals reach the joints, s.")] = 0.02,
    balance: Annotated[bool, typer.Option(help="Level the body by its measured attitude.")] = True,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Seed of stones and sensor noise.")] = 0,
    honest: Honest = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help=f"Write {', '.join(FILES)} here.")] = None,
    as_json: Json = False,
) -> int:
    """Let a simulated robot walk and print the figures; --out writes an animation, a moving picture and the path.

    Exit code 0 if it arrived as commanded, 1 with the reason if it did not, 2 for wrong use. The plane has no left and
    right, and is fast to compute; in space the robot can also roll, turn and drift, and is drawn from the side.

    Examples: caramelo walk; caramelo walk --in space; caramelo walk --gait paper-trot --terrain step --height 0.05;
    caramelo walk --robot parallel --speed 0.1 --out out/parallel
    """
    from ..robot.actuators import Bldc
    from ..robot.file import load_robot
    from ..robot.gait_file import with_gait
    from ..sim.grounds import STONES, GroundSpec
    from ..sim.motor.walking import joint_motors, transport
    from ..sim.walk import WalkSpec, judged, run_walk, walk_result
    from ..util.files import check_folder

    check_folder("--out", out)
    data = with_gait(load_robot(robot).simulated(honest), gait)
    if terrain in STONES and length is None:
        length = max(0.1, distance)
    spec = WalkSpec(
        robot=data,
        gait=data.gait.default,
        speed_m_s=speed,
        ground=GroundSpec(terrain, height, angle, start, length, seed),
        distance_m=distance,
        payload_kg=payload,
        friction=friction,
        voltage_V=voltage,
        bus_delay_s=bus_delay,
        balance=balance,
        seed=seed,
    )
    if where not in WORLDS:
        raise UserError(f"--in {where}: allowed {' or '.join(WORLDS)}")
    more: dict[str, Any] = {}
    motors = joint_motors(data) if isinstance(data.actuator, Bldc) and where == "plane" else None
    with progress(f"{data.name} walks {distance:g} m ({terrain})", 1.0) as show:
        if where == "plane":
            recording = run_walk(spec, show, actuator=motors)
        else:
            from ..sim.space.walk import figures, walk_in_space

            recording = walk_in_space(spec, show)
            told = figures(recording)
            more = {key: told[key] for key in ("roll_range_deg", "yaw_drift_deg", "side_drift_m")}
    result = judged(spec, walk_result(spec, recording), in_space=where == "space")
    result |= transport(data, recording, payload, motors) | more
    result["in"] = where
    written = write_results(out, spec, recording, result) if out else []
    if as_json:
        write_json(result)
    else:
        show_result(result, written)
    return 0 if result["ok"] else NOT_ACHIEVED


def write_results(out: Path, spec: "WalkSpec", recording: "Recording", result: dict[str, Any]) -> list[Path]:
    """Write the animation, the pictures and the figures into ``out``; return the files."""
    import json

    from sim2d.moving import moving_svg
    from sim2d.view import animation_html, path_png

    from ..sim.walk import facts
    from ..util.files import atomic_path, write_text

    title = f"{spec.robot.name}: {spec.gait} over {spec.ground.name}"
    page, moving, picture, figures = (out / name for name in FILES)
    length_m, width_m, height_m = (size_m / 2 for size_m in spec.robot.links.trunk.size_m)
    write_text(page, animation_html(recording, title, result["reason"], facts(result), (length_m, height_m)))
    write_text(moving, moving_svg(recording, f"{title}: {result['reason']}", (length_m, width_m, height_m)))
    with atomic_path(picture) as draft:
        path_png(recording, f"{title}: {result['reason']}", draft)
    write_text(figures, json.dumps(result, indent=1) + "\n")
    return [page, moving, picture, figures]


def show_result(result: dict[str, Any], written: list[Path]) -> None:
    """Print the walk's figures as tables, and how it ended."""
    from rich.text import Text

    from ..sim.walk import facts

    shares = result["torque_rms_fraction"]
    torques = [(leg, *(f"{100 * shares[f'{leg}_{joint}']:>4.0f}" for joint in ("hip", "thigh", "calf")))
               for leg in dict.fromkeys(name.partition("_")[0] for name in shares)]
    print_table((), facts(result))
    print_table(("torque rms, % of stall", " hip", "thigh", "calf"), torques)
    screen().print(Text("ok" if result["ok"] else "not achieved", style="bold"), result["reason"], sep=": ")
    if not result["ok"] and result["height_m"] and result["in"] == "plane":
        hint = "edges are harder in the plane (docs/gaits.md): try --in space, or another --seed"
        screen().print(hint, soft_wrap=True)
    tell_written(written)
