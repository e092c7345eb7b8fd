"""Imaginary robots for the tests: drawn at random, measured over the servos' own protocol, compared with the draw."""

from host.bus.base import JOINTS
from host.bus.dynamixel.calibration.data import nominal
from host.identify.carried import in_the_air
from host.identify.fit import Fitted, JointFit
from host.identify.model import NAMES
from host.identify.sweeping import shake_all, stand_and_sway, sweep_joint
from host.identify.together import grounds, supply_ohm
from host.robot.file import load_robot
from host.robot.poses import rest_pose_rad
from host.sim.servos.honest import HonestStand, drawn

ROBOT = load_robot("caramelo")
SERVO = ROBOT.actuator
# What is drawn; the torques' and the law's shapes that are not fitted stay as the file has them.
COMPARED = [name for name in NAMES if name != "act_s"]


def stand(seed: int, fault: str = "", joint: int = 0) -> HonestStand:
    """Return an imaginary robot on its stand, ready to be measured."""
    made = HonestStand(ROBOT, nominal(ROBOT), drawn(ROBOT, seed, fault, joint), rest_pose_rad(ROBOT))
    made.rig.prepare()
    return made


def truth(made: HonestStand, joint: int) -> dict[str, float]:
    """Return what was drawn of one joint, by model.NAMES."""
    f = made.plant.made.figures[joint]
    own = {name: getattr(f, name) for name in (
        "stall_Nm", "no_load_rad_s", "duty_per_rad", "coulomb_Nm", "armature_kg_m2", "backlash_rad",
    )}  # fmt: skip
    return own | {"act_s": f.delay_s} | {name: getattr(f.friction, name) for name in (
        "stribeck_Nm", "stribeck_rad_s", "viscous_Nms_rad", "load_motor", "load_external",
    )}  # fmt: skip


def errors(made: HonestStand, joint: int, fitted: Fitted) -> dict[str, float]:
    """Return by which share each number is off, and the delay by how many ms."""
    true = truth(made, joint)
    off = {name: fitted.values[name] / true[name] - 1 for name in COMPARED}
    delay_s = made.plant.made.figures[joint].delay_s + made.plant.made.answer_s
    return off | {"delay_ms": 1000 * (fitted.delay_s - delay_s)}


def measured(seed: int, joint: int):
    """Return a robot, one joint's fit, and the supply's resistance as found and as drawn.

    The other joints' numbers are taken to be found as well as this one's.
    """
    made = stand(seed)
    traces, shaken = sweep_joint(made.rig, joint), shake_all(made.rig)
    made.put_on_ground()
    ground = grounds(ROBOT, SERVO, stand_and_sway(made.rig))[joint]
    fitted = JointFit(SERVO, in_the_air(ROBOT, joint), traces, ground).run()
    share = {name: fitted.values[name] / truth(made, joint)[name] for name in NAMES}
    drawn_numbers = [truth(made, other) for other in range(JOINTS)]
    numbers = [{name: share[name] * own[name] for name in NAMES} for own in drawn_numbers]
    found = supply_ohm(SERVO, [in_the_air(ROBOT, other) for other in range(JOINTS)], numbers, shaken)
    return made, fitted, (found, made.plant.made.supply_ohm)
