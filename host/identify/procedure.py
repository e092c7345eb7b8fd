"""The whole measurement: sweep joint by joint, shake all, stand and sway; then fit, judge, and draw.

After every joint the measurements are kept (keeping.py), so that one can stop and go on later, and fit without the
robot.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import degrees
from pathlib import Path

from ..bus.base import JOINT_LABELS, JOINTS
from ..bus.dynamixel.calibration.data import servo_of
from ..bus.dynamixel.calibration.procedure import reference_rad
from ..robot.model import Robot
from ..util.errors import UserError
from ..util.files import write_text
from . import keeping
from .carried import in_the_air, joint_per_shaft
from .filing import Measure
from .fit import Fitted, JointFit
from .rig import Rig
from .sweeping import Blocked, Trace, shake_all, stand_and_sway, sweep_joint
from .together import grounds, supply_ohm
from .verdict import BLOCKED, SOUND, UNSAFE, Verdict, broken, brothers, judge, sticking, weight_is, with_middle

Show = Callable[[str, float], None]  # the present work, and the share of it that is done
# Runs fits, in this process or elsewhere, and returns what they find in their order; told is how many have ended.
RunFits = Callable[[Sequence[JointFit], Callable[[int], None]], list[Fitted]]
LEAST_BROTHERS = 2


@dataclass
class Result:
    """The result: fits of the intact joints, a verdict on each joint, and the supply's resistance."""

    fits: dict[int, Fitted] = field(default_factory=dict)
    verdicts: dict[int, Verdict] = field(default_factory=dict)
    supply_ohm: float | None = None
    stood: bool = False

    @property
    def sound(self) -> bool:
        """True if nothing is wrong with any joint."""
        return all(verdict.kind == SOUND for verdict in self.verdicts.values())


def measure_in_air(rig: Rig, folder: Path, joints: Sequence[int], show: Show) -> None:
    """Sweep joints that are not kept yet, then shake all together; keep the measurements."""
    robot = rig.robot
    for joint in joints:
        if keeping.done(folder, joint) or _blocked_path(folder, joint).exists():
            continue
        label = JOINT_LABELS[joint]
        try:
            traces = sweep_joint(rig, joint, lambda share, label=label: show(label, share))  # type: ignore[misc]
        except Blocked as error:
            write_text(_blocked_path(folder, joint), f"{error}\n")
            continue
        keeping.keep_traces(keeping.path_of(folder, joint), robot, traces)
    path = keeping.together_path(folder, "shake")
    whole = all(keeping.done(folder, joint) for joint in range(JOINTS))
    if whole and not path.exists():
        keeping.keep_stances(path, robot, shake_all(rig, lambda share: show("all joints", share)))


def measure_on_ground(rig: Rig, folder: Path, show: Show) -> None:
    """Stand and sway, and keep the measurements."""
    path = keeping.together_path(folder, "ground")
    keeping.keep_stances(path, rig.robot, stand_and_sway(rig, lambda share: show("standing", share)))


def _blocked_path(folder: Path, joint: int) -> Path:
    return keeping.path_of(folder, joint).with_suffix(".blocked")


def glance(robot: Robot, folder: Path, show: Show) -> dict[int, Verdict]:
    """Return the joints that can't be fitted and that forbid standing up: blocked, loose, reversed ones."""
    found = {}
    for joint in range(JOINTS):
        if _blocked_path(folder, joint).exists():
            why = _blocked_path(folder, joint).read_text(encoding="utf-8").strip()
            found[joint] = Verdict(joint, BLOCKED, f"{why}; repair it, then remove {_blocked_path(folder, joint).name}")
        elif keeping.done(folder, joint):
            show(f"{JOINT_LABELS[joint]}: weight", joint / JOINTS)
            kind = _weight(robot, joint, keeping.kept_traces(keeping.path_of(folder, joint), robot))
            if kind != SOUND:
                found[joint] = broken(joint, kind)
    return found


def _weight(robot: Robot, joint: int, traces: list[Trace]) -> str:
    mirror_rad = reference_rad(robot, joint) / joint_per_shaft(robot, joint)
    return weight_is(servo_of(robot), in_the_air(robot, joint), traces, mirror_rad)


def unsafe(verdicts: Mapping[int, Verdict]) -> list[str]:
    """Return the sentences that forbid standing up."""
    return [verdict.sentence for verdict in verdicts.values() if verdict.kind in UNSAFE]


def fit_all(robot: Robot, folder: Path, show: Show, run_fits: RunFits) -> Result:
    """Fit every joint that is kept, and judge it. UserError if nothing is kept."""
    servo, result = servo_of(robot), Result()
    kept = [joint for joint in range(JOINTS) if keeping.done(folder, joint)]
    result.verdicts = glance(robot, folder, show)
    if not kept and not result.verdicts:
        raise UserError(f"{folder}: contains no sweeps: measure first, with caramelo identify")
    ground = grounds(robot, servo, keeping.kept_stances(keeping.together_path(folder, "ground"), robot))
    result.stood = ground is not None
    whole = [joint for joint in kept if joint not in result.verdicts]
    loads = [in_the_air(robot, joint) for joint in range(JOINTS)]
    traces = {joint: keeping.kept_traces(keeping.path_of(folder, joint), robot) for joint in whole}
    fits = [JointFit(servo, loads[joint], traces[joint], ground[joint] if ground else None) for joint in whole]
    show(f"{len(fits)} joints", 0.0)
    found = run_fits(fits, lambda ended: show(f"{ended} of {len(fits)} joints", ended / len(fits)))
    result.fits = dict(zip(whole, found, strict=True))
    for joint in whole:
        sticks = sticking(servo, loads[joint], traces[joint], brothers(result.fits, joint))
        result.verdicts[joint] = judge(joint, result.fits, sticks)
    if result.fits:
        shaken = keeping.kept_stances(keeping.together_path(folder, "shake"), robot)
        result.supply_ohm = supply_ohm(servo, loads, all_numbers(result.fits), shaken)
    return result


def all_numbers(fits: Mapping[int, Fitted]) -> list[dict[str, float]]:
    """Return each joint's numbers; where it was not fitted, the medians of those that were."""
    middle = with_middle(fits)
    return [fits.get(joint, middle).values for joint in range(JOINTS)]


def measures(result: Result) -> dict[str, Measure]:
    """Return the numbers for the robot file: medians of the sound joints, by table and key; none of too few."""
    sound = {j: fit for j, fit in result.fits.items() if result.verdicts[j].kind == SOUND and fit.fits}
    if len(sound) < LEAST_BROTHERS:
        return {}
    middle = with_middle(sound)
    values, spread = middle.values, middle.spread
    found = {
        f"actuator.{name}": Measure(values[name], spread[name])
        for name in ("duty_per_rad", "armature_kg_m2", "coulomb_Nm")
    }
    found["actuator.backlash_deg"] = Measure(degrees(values["backlash_rad"]), spread["backlash_rad"])
    friction = ["stribeck_Nm", "stribeck_rad_s", "viscous_Nms_rad", "load_motor", *["load_external"] * result.stood]
    found |= {f"actuator.friction.{name}": Measure(values[name], spread[name]) for name in friction}
    found["bus.delay_s"] = Measure(values["act_s"] + middle.answer_s)
    found["no_load_rad_s"] = Measure(values["no_load_rad_s"], spread["no_load_rad_s"])
    if result.stood:
        found["stall_Nm"] = Measure(values["stall_Nm"], spread["stall_Nm"])
    if result.supply_ohm is not None:
        found["actuator.supply_ohm"] = Measure(result.supply_ohm)
    return found
