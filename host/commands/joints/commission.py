"""`caramelo joints commission`: lets a joint measure its own motor, and prints the results."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...util.console import print_table, progress, screen, write_error, write_json
from ...util.errors import NOT_ACHIEVED, UserError
from ...util.files import check_file
from .options import NODES, Channel, Interface, Json, RobotName, Sim, joints

if TYPE_CHECKING:
    from ...bus.can.commission import Found
    from ...bus.can.joints import CanJoints

TAKES_S = 45.0  # about; for the progress bar
MOTOR_KEYS = ("pole_pairs", "resistance_ohm", "inductance_H", "torque_constant_Nm_A", "coulomb_Nm")


def commission(
    node: Annotated[str, typer.Argument(metavar="NODE|all", help=f"{NODES}; or all, one by one.")],
    verify: Annotated[bool, typer.Option("--verify", help="Compare direction and offset; change nothing.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write a copy of the robot file with the results of the joints that passed."),
    ] = None,
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Let a joint measure its motor in the leg, set its loops and save the results. Exit code 1 if it fails.

    The rotor turns a little more than once from where it stands: keep the legs in the air and the joint in the middle
    of its range. With --sim each joint is simulated with its motor.

    Examples: caramelo joints commission 5 --sim; caramelo joints commission all --out measured.toml
    """
    from ...robot.file import load_robot

    nodes = _nodes(node)
    if verify and out:
        raise UserError("--out: not with --verify, which finds nothing to write")
    check_file("--out", out)
    if out and (out.suffix != ".toml" or out.exists() or not out.parent.is_dir()):
        raise UserError(f"--out {out}: give a new file ending in .toml, in a folder that exists")
    bldc = load_robot(robot).actuator
    made: list[Found] = []
    failed: dict[int, str] = {}
    with joints(robot, interface, channel, sim, nodes) as bus, progress("commissioning", TAKES_S * len(nodes)) as show:
        for number, one in enumerate(nodes):
            try:
                made += _one(bus, one, verify, lambda s, n=number: show(n * TAKES_S + s), bldc)
            except UserError as error:
                failed[one] = str(error)
                if not as_json:
                    write_error(str(error))
    if not as_json:
        _show(made)
    if out and made:
        _write(robot, out, made)
    _tell(made, len(nodes) - len(failed), failed, "verified" if verify else "commissioned", out, as_json)
    return NOT_ACHIEVED if failed else 0


def _nodes(text: str) -> list[int]:
    if text == "all":
        return list(range(1, 13))
    if not text.isdecimal() or not 1 <= int(text) <= 12:
        raise UserError(f"NODE {text}: give 1 .. 12, or all")
    return [int(text)]


def _one(bus: "CanJoints", node: int, verify: bool, show: Any, bldc: Any) -> "list[Found]":
    """Commission one joint and let it save the results; return nothing when it only verifies."""
    from shared.wire import names as w

    from ...bus.can.commission import found, run

    run(bus, node, verify, show)
    if verify:
        return []
    bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    return [found(bus, node, bldc)]


def _write(robot: str, out: Path, made: "list[Found]") -> None:
    """Write the copy: the median of each value, and the largest difference of a joint from it."""
    from datetime import date
    from statistics import median

    from ...identify.filing import Measure, write_checked
    from ...robot.file import find

    values = {}
    for name, each in _measured(robot, made).items():
        middle = median(each)
        spread = max(abs(value / middle - 1) for value in each) if len(each) > 1 else None
        new = Measure(middle, spread).new(middle, "", date.today())
        values[name] = replace(new, value=round(middle)) if name == "actuator.motor.pole_pairs" else new
    write_checked(find(robot), out, values)


def _measured(robot: str, made: "list[Found]") -> dict[str, list[float]]:
    """Return the values for the robot file, from every joint that found them.

    The rotor's own inertia is the measured one less the inertia that the joint turns by the file; none if none is left.
    """
    from ...robot.file import load_robot
    from ...robot.joint_setups import joint_setups

    data = load_robot(robot)
    setups, gear = joint_setups(data), data.actuator.gear.ratio  # type: ignore[union-attr]
    found = {f"actuator.motor.{key}": [getattr(one, key) for one in made] for key in MOTOR_KEYS}
    own = [one.inertia_kg_m2 - setups[one.node - 1].inertia_kg_m2 / gear**2 for one in made]
    found["actuator.motor.rotor_inertia_kg_m2"] = own if min(own) > 0 else []
    found["actuator.gear.backlash_deg"] = [one.backlash_deg for one in made if one.backlash_deg is not None]
    return {name: each for name, each in found.items() if each}


def _show(made: "list[Found]") -> None:
    """Print two tables of what the joints found, before a file could be refused."""
    if not made:
        return
    head = ("node", "pole pairs", "direction", "R ohm", "Ld mH", "Lq mH", "N m/A", "magnet deg", "lag deg")
    print_table(head, [
        (
            f.node, f.pole_pairs, f.direction, f"{f.resistance_ohm:.4g}", f"{f.inductance_d_H * 1e3:.4g}",
            f"{f.inductance_q_H * 1e3:.4g}", f"{f.torque_constant_Nm_A:.4g}", f"{f.eccentricity_deg:.2f}",
            f"{f.friction_lag_deg:.1f}",
        )
        for f in made
    ])  # fmt: skip
    swung = ("node", "inertia kg m2", "friction N m", "growing N m s", "play deg", "cogging N m", "velocity Hz")
    print_table(swung, [
        (
            f.node, f"{f.inertia_kg_m2:.3g}", f"{f.coulomb_Nm:.3g}", f"{f.viscous_Nms_rad:.2g}",
            "no joint encoder" if f.backlash_deg is None else f"{f.backlash_deg:.3f}",
            f"{f.cogging_Nm:.2g}", f"{f.velocity_bandwidth_hz:.3g}",
        )
        for f in made
    ])  # fmt: skip


def _tell(made: "list[Found]", passed: int, failed: dict[int, str], done: str, out: Path | None, as_json: bool) -> None:
    written = str(out) if out and made else None
    if as_json:
        write_json({"joints": [asdict(one) for one in made], "failed": failed, "file": written})
        return
    file = f"; {out} written from them" if written else f"; {out} not written" if out else ""
    screen().print(f"{passed} of {passed + len(failed)} joints {done}{file}", soft_wrap=True)
