"""What is believed of the senses: joints and tilt, what the legs tell, and where the robot has walked to."""

from ..body.params import JOINTS
from ..runtime import Ints, hot
from ..sense.legs import sense_legs, sensing_reset
from ..sense.odometry import odometry_lost, odometry_step, weigh_feet
from ..sense.sensed import PITCH, ROLL, Sensed
from .goals import believe
from .state import PlannerState
from .status import ODD_READING, STANDING, WALKING


@hot
def take_senses(planner: PlannerState, sensed: Sensed) -> None:
    """Write into ``planner.sensed`` what may be believed of ``sensed``. ODD_READING if not all of it.

    Until the joints are known, what was read of them last are the goals: of a limp robot, that are not driven.
    """
    valid = sensed.valid
    believed = planner.sensed
    known = believed.valid
    known.tilt = 0
    if valid.tilt:
        odd = believe(sensed.tilt, 2, planner.params.tilt_step, believed.tilt, planner.tilt_past)
        known.tilt = note_odd(planner, odd)
    known.joints = 0
    if valid.joints:
        odd = believe(sensed.joints, JOINTS, planner.params.read_step, believed.joints, planner.joints_past)
        if planner.status.joints_seen == 0:
            meet(planner, believed.joints)
        known.joints = note_odd(planner, odd)
        planner.status.joints_seen |= known.joints
    known.turned = valid.turned
    believed.turned.x = sensed.turned.x
    believed.turned.y = sensed.turned.y
    believed.turned.z = sensed.turned.z


@hot
def note_odd(planner: PlannerState, odd: int) -> int:
    """Set ODD_READING if some readings were odd; return 1 if the others are known (``odd`` is not -1), else 0."""
    if odd > 0:
        planner.status.flags |= ODD_READING
    if odd < 0:
        return 0
    return 1


@hot
def meet(planner: PlannerState, read: Ints) -> None:
    """Take the joints as they were read as the goals."""
    for joint in range(JOINTS):
        planner.goal[joint] = read[joint]
        planner.joints[joint] = read[joint]


@hot
def feel_legs(planner: PlannerState) -> None:
    """Take what the legs of a robot tell that stands or walks.

    Where the tilt is not known it is taken as none. What is not measured tells nothing.
    """
    if planner.status.state != STANDING and planner.status.state != WALKING:
        if planner.sensing.known:
            sensing_reset(planner.sensing)
        return
    if planner.sensed.valid.joints == 0:
        return
    roll = 0
    pitch = 0
    if planner.sensed.valid.tilt:
        roll = planner.sensed.tilt[ROLL]
        pitch = planner.sensed.tilt[PITCH]
    sense_legs(planner.params, planner.sensed.joints, roll, pitch, planner.measured_feet, planner.sensing)


@hot
def follow_way(planner: PlannerState) -> int:
    """Follow the body's way over the feet that stand, as planned in this tick; return 1, 0 where they tell nothing.

    In the hand they tell no way, only what they carry.
    """
    status = planner.status
    if planner.sensing.known == 0 or planner.sensed.valid.joints == 0:
        odometry_lost(planner.odometry)
        return 0
    if status.lifted:
        odometry_lost(planner.odometry)
        weigh_feet(planner.params, planner.sensing, status.swinging, planner.odometry)
        return 1
    walks = 0
    if status.state == WALKING:
        walks = 1
    odometry_step(planner.params, planner.sensing, planner.sensed, status.swinging, walks, planner.odometry)
    return 1
