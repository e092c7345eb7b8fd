"""`caramelo robots`: lists, shows, checks and writes robot files."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, say, write_json
from ..util.errors import NOT_ACHIEVED
from ._new_robot import new_robot
from ._options import Json

if TYPE_CHECKING:
    from ..robot.ability import Ability
    from ..robot.model import Robot

JOINTS = ("hip", "thigh", "calf")

Which = Annotated[str, typer.Argument(metavar="ROBOT", help="A robot's name, or a file ending in .toml.")]

GROUP = typer.Typer(help="List, show, check and write robot files.", invoke_without_command=True)


@GROUP.callback()
def list_robots(context: typer.Context, as_json: Json = False) -> None:
    """List, show, check and write robot files. Without a command, list the robots that --robot knows.

    Examples: caramelo robots; caramelo robots show parallel --json; caramelo robots check my.toml;
    caramelo robots new my.toml
    """
    if context.invoked_subcommand is not None:
        return
    from ..robot.file import load_robot, robot_names

    robots = [load_robot(name) for name in robot_names()]
    if as_json:
        write_json({"robots": [{"name": robot.name, "description": robot.description} for robot in robots]})
        return
    print_table((), [(robot.name, robot.description) for robot in robots])


@GROUP.command("show")
def show_robot(which: Which, as_json: Json = False) -> None:
    """Show a robot's most important figures, or with --json everything in its file.

    Example: caramelo robots show caramelo
    """
    from ..robot.file import find, load_robot

    robot = load_robot(which)
    if as_json:
        write_json({**robot.model_dump(mode="json"), "derived": derived(robot)})
        return
    print_table((), [*overview(robot), ("file", str(find(which)))])


@GROUP.command("check")
def check_robot(which: Which, as_json: Json = False) -> int:
    """Check a robot file, and print what the robot can do. Exit code 2 and one line if the file is wrong.

    Exit code 1 if the robot can't carry itself; one line then says what it lacks and which key to change.

    Example: caramelo robots check my.toml
    """
    from ..robot.ability import ability, cannot
    from ..robot.file import RobotFileError, load_robot

    try:
        robot = load_robot(which)
    except RobotFileError as error:
        if as_json:
            write_json({"ok": False, "file": which, "reason": str(error)})
        raise
    known = ability(robot)
    lacks = list(cannot(robot, known))
    if as_json:
        found = {"ok": not lacks, "file": which, "name": robot.name, "derived": derived(robot)}
        write_json(found | {"ability": asdict(known), "lacks": lacks})
    else:
        verdict = "can't walk" if lacks else "ok"
        say(f'{which}: {verdict}: "{robot.name}", {robot.mass_kg:.3f} kg')
        print_table((), ability_rows(robot, known))
        for sentence in lacks:
            say(sentence)
    return NOT_ACHIEVED if lacks else 0


GROUP.command("new")(new_robot)


def ability_rows(robot: "Robot", known: "Ability") -> list[tuple[str, str]]:
    """Return what a robot can do, as rows of name and value with unit."""
    from ..robot.ability import FLAT_FROUDE
    from ..robot.trot_tuning import fastest, limit

    shares = [
        ", ".join(f"{joint} {100 * share:.0f}" for joint, share in zip(JOINTS, found, strict=True))
        for found in (known.on_four, known.on_two)
    ]
    sag = "folds up" if known.sag_m is None else f"sags {1000 * known.sag_m:.1f} mm"
    return [
        ("stands on four legs", f"{shares[0]} % of stall torque; {sag}"),
        ("on two, as in a trot", f"{shares[1]} %"),
        ("walks level ground at", f"{known.flat_m_s:.2f} m/s: {FLAT_FROUDE:g} sqrt(g h), or what its legs can"),
        ("its legs can", f"{known.able_m_s:.2f} m/s: {known.able_why}"),
        ("its file allows", f"{fastest(robot)[0]:.2f} m/s: {limit(robot)}"),
        ("lifts a foot", f"{1000 * known.lift_m:.0f} mm while it climbs: {known.lift_why}"),
        ("steps up at a trot", f"{1000 * known.step_m:.0f} mm"),
    ]


def derived(robot: "Robot") -> dict[str, Any]:
    """Return the values that follow from a robot's file."""
    from ..robot.gait_advice import gait_advice

    return {
        "mass_kg": robot.mass_kg,
        "reach_m": robot.geometry.reach_m,
        "length_unit_m": 2.0**-robot.length_shift,
        "gaits_not_advised": {gait: reason for gait, reason in gait_advice(robot).items() if reason},
    }


def overview(robot: "Robot") -> list[tuple[str, str]]:
    """Return the most important figures, as rows of name and value with unit."""
    from ..robot.checks import reachable_heights
    from ..robot.gait_advice import gait_advice

    geometry, stance, limits, speed = robot.geometry, robot.stance, robot.joint_limits, robot.speed_limits
    ranges = [f"{low:g} .. {high:g}" for low, high in (limits.hip_deg, limits.thigh_deg, limits.calf_deg)]
    hip_x_m, hip_y_m = geometry.hips_m.FL
    return [
        ("robot", f"{robot.name}: {robot.description}"),
        ("mass", f"{robot.mass_kg:.3f} kg, trunk {robot.links.trunk.mass_kg:g} kg"),
        ("links", "hip offset {:g}, thigh {:g}, calf {:g} m".format(*geometry.links_m)),
        ("hips", f"x +-{hip_x_m:g}, y +-{hip_y_m:g} m"),
        ("knees", geometry.knee_configuration),
        ("height", f"rest {stance.rest_height_m:g}, sitting {stance.sit_height_m:g}, {reachable_heights(robot)}"),
        ("joint limits", "hip {}, thigh {}, calf {} deg".format(*ranges)),
        ("calf motor", f"on the {robot.calf_drive.motor_on}, ratio {robot.calf_drive.ratio:g}"),
        ("actuator", _actuator(robot)),
        ("speed", f"x {speed.vx_m_s:g} m/s, y {speed.vy_m_s:g} m/s, turning {speed.wz_rad_s:g} rad/s"),
        ("planner", f"{robot.control.rate_hz} Hz, gait {robot.gait.default}"),
        *((f"gait {gait}", _advice(robot, gait, reason)) for gait, reason in gait_advice(robot).items()),
        ("length unit", f"2^-{robot.length_shift} m"),
    ]


def _advice(robot: "Robot", gait: str, reason: str) -> str:
    return f"not advised: {reason}" if reason else f"advised up to {robot.gait.advised_m_s[gait]:g} m/s"


def _actuator(robot: "Robot") -> str:
    if robot.actuator.kind == "servo":
        point = robot.actuator.nominal
        return f"{robot.actuator.model}, {point.stall_Nm:g} N m, {point.no_load_rpm:g} rpm at {point.voltage_V:g} V"
    if robot.actuator.kind == "pd":
        pd = robot.actuator
        held = f"{pd.stiffness_Nm_rad:g} N m/rad and {pd.damping_Nms_rad:g} N m s/rad"
        return f"{pd.model}, {pd.torque_Nm:g} N m, {pd.no_load_rad_s:g} rad/s, holds with {held}"
    joint = robot.actuator
    torque = f"{joint.torque_limit_Nm:.2f} N m at {joint.drive.current_limit_A:g} A"
    return f"brushless, gear {joint.gear.ratio:g}:1, {torque}, {joint.drive.bus_voltage_V:g} V"
