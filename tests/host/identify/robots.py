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
    """Return what was drawn of one joint."""
    f = made.plant.made.figures[joint]
    own = {name: getattr(f, name) for name in (
        "stall_Nm", "no_load_rad_s", "duty_per_rad", "coulomb_Nm", "armature_kg_m2", "backlash_rad",
    )}  # fmt: skip
    return own | {name: getattr(f.friction, name) for name in (
        "stribeck_Nm", "stribeck_rad_s", "viscous_Nms_rad", "load_motor", "load_external",
    )}  # fmt: skip


def no_loads_rad_s(made: HonestStand) -> list[float]:
    """Return every joint's no-load speed as drawn."""
    return [truth(made, joint)["no_load_rad_s"] for joint in range(JOINTS)]


def errors(made: HonestStand, joint: int, fitted: Fitted) -> dict[str, float]:
    """Return by which share each number is off, and the delay by how many ms."""
    true = truth(made, joint)
    off = {name: fitted.values[name] / true[name] - 1 for name in COMPARED}
    delay_s = made.plant.made.figures[joint].delay_s + made.plant.made.answer_s
    return off | {"delay_ms": 1000 * (fitted.delay_s - delay_s)}


def measured(seed: int, joint: int):
    """Return a robot, one joint's fit, and the supply's resistance as found and as drawn.

    The other joints' no-load speeds are taken to be found as well as this one's.
    """
    made = stand(seed)
    traces, shaken = sweep_joint(made.rig, joint), shake_all(made.rig)
    made.put_on_ground()
    ground = grounds(ROBOT, SERVO, stand_and_sway(made.rig))[joint]
    fitted = JointFit(SERVO, in_the_air(ROBOT, joint), traces, ground).run()
    drawn_rad_s = no_loads_rad_s(made)
    share = fitted.values["no_load_rad_s"] / drawn_rad_s[joint]
    found = supply_ohm(SERVO, [share * speed for speed in drawn_rad_s], shaken)
    return made, fitted, (found, made.plant.made.supply_ohm)
