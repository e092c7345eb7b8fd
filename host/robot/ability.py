"""What a robot will be able to do, from its file alone: the torque to stand, its speed, how high it steps.

`caramelo robots check` prints it. Torques: host/robot/statics.py; speeds and lifts: host/robot/trot_tuning.py.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

from sim2d.model import GRAVITY_M_S2

from .drives import STIFFNESS_KEYS
from .kinematics_si import Vector
from .mass import com_at_rest_m
from .model import JOINT_NAMES, Robot
from .statics import push_on_two_N, pushes_on_four_N, sag_m, torque_shares
from .trot_tuning import STEP_LEG, able, highest_lift_m, trot_figures

FLAT_FROUDE = 0.25  # of sqrt(g h): the speed that every robot should walk on level ground
STEP_OF_LIFT = 0.78  # of a swing's top; a robot whose calves are slow trots up 30 of 40 such steps, and 15 at 0.88
MOST_TORQUE = 1.0  # of stall while two legs carry; Caramelo with weaker servos walks at 0.9 and not at 1.1
BETWEEN_FEET = 0.95  # of the way from the middle to the feet: Caramelo with its mass at 0.96 falls while its joints sag
TORQUE_KEYS = {  # by kind of actuator: the key that gives its joints more torque
    "servo": "actuator.supply.stall_Nm",
    "bldc": "actuator.drive.current_limit_A",
    "pd": "actuator.torque_Nm",
}


@dataclass(frozen=True)
class Ability:
    """Shares are parts of the torque at standstill, for hip, thigh and calf.

    The sag is without feed-forward; None if the legs fold up.
    """

    sag_m: float | None
    on_four: Vector
    on_two: Vector
    able_m_s: float
    able_why: str
    flat_m_s: float
    lift_m: float
    lift_why: str
    step_m: float


def ability(robot: Robot) -> Ability:
    """Return what a robot can do."""
    figures = trot_figures(robot)
    able_m_s, able_why = able(robot)
    lift_m, lift_why = highest_lift_m(robot)
    return Ability(
        sag_m=sag_m(robot),
        on_four=torque_shares(robot, pushes_on_four_N(robot)),
        on_two=torque_shares(robot, [push_on_two_N(robot)] * 4),
        able_m_s=able_m_s,
        able_why=able_why,
        flat_m_s=min(able_m_s, FLAT_FROUDE * sqrt(GRAVITY_M_S2 * figures.height_m)),
        lift_m=lift_m,
        lift_why=lift_why,
        step_m=min(STEP_OF_LIFT * lift_m, STEP_LEG * figures.leg_m),
    )


def cannot(robot: Robot, known: Ability) -> Iterator[str]:
    """Yield a sentence for each thing that keeps a robot from walking, with the key to change; none if it can walk."""
    yield from _tips_over(robot)
    more = TORQUE_KEYS[robot.actuator.kind]
    worst = max(range(3), key=known.on_two.__getitem__)
    if known.on_two[worst] > MOST_TORQUE:
        yield (
            f"standing on two legs, as in a trot, the {JOINT_NAMES[worst]} needs {known.on_two[worst]:.2g} times its "
            f"stall torque, and on four {known.on_four[worst]:.2g}: raise {more}, lower links.trunk.mass_kg, or raise "
            f"stance.rest_height_m"
        )
    if known.sag_m is None:
        stiffer = STIFFNESS_KEYS[robot.actuator.kind]
        yield f"on four legs the joints are so soft that they fold up: raise {stiffer}, or lower links.trunk.mass_kg"
    if known.able_m_s == 0:
        yield (
            f"a swing takes {trot_figures(robot).swing_s:.2f} s, too short for {known.able_why} to lift a foot even "
            f"on the spot: use faster drives, or raise stance.rest_height_m"
        )


def _tips_over(robot: Robot) -> Iterator[str]:
    """Yield a sentence for each axis along which the centre of mass is not between the feet at rest."""
    for axis, at_m in enumerate(com_at_rest_m(robot)[:2]):
        front_right, rear_left = (robot.hip_m(leg)[axis] + robot.foot_m(leg, 0.0)[axis] for leg in (0, 3))
        middle_m, most_m = (front_right + rear_left) / 2, BETWEEN_FEET * abs(front_right - rear_left) / 2
        if abs(at_m - middle_m) > most_m:
            yield (
                f"it tips over: its centre of mass is at {'xy'[axis]} = {at_m:.3f} m, and must be well between its "
                f"feet, within {middle_m - most_m:.3f} .. {middle_m + most_m:.3f} m: change links.trunk.com_m"
            )
