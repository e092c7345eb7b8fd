"""What the planner believes: joints and tilt, what the legs feel, and how far the robot has walked."""

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
    """Copy into ``planner.sensed`` what is believed of ``sensed``; set ODD_READING if some readings are not.

    Until the joints are first known the goals follow their readings: the robot is limp then, and no joint is driven.
    """
    valid = sensed.valid
    believed = planner.sensed
    known = believed.valid
    known.tilt = 0
    if valid.tilt:
        odd = believe(sensed.tilt, 2, planner.params.tilt_step, believed.tilt, planner.tilt_history)
        known.tilt = flag_odd(planner, odd)
    known.joints = 0
    if valid.joints:
        odd = believe(sensed.joints, JOINTS, planner.params.read_step, believed.joints, planner.joints_history)
        if planner.status.joints_seen == 0:
            reset_goals(planner, believed.joints)
        known.joints = flag_odd(planner, odd)
        planner.status.joints_seen |= known.joints
    known.turned = valid.turned
    believed.turned.x = sensed.turned.x
    believed.turned.y = sensed.turned.y
    believed.turned.z = sensed.turned.z


@hot
def flag_odd(planner: PlannerState, odd: int) -> int:
    """Set ODD_READING if some readings were odd; return 1 if the others are known (``odd`` is not -1), else 0."""
    if odd > 0:
        planner.status.flags |= ODD_READING
    if odd < 0:
        return 0
    return 1


@hot
def reset_goals(planner: PlannerState, read: Ints) -> None:
    """Set the goals to the joints as read."""
    for joint in range(JOINTS):
        planner.goal[joint] = read[joint]
        planner.joints[joint] = read[joint]


@hot
def update_sensing(planner: PlannerState) -> None:
    """Update what the legs feel while the robot stands or walks; forget it in all other states.

    An unknown tilt counts as level. Without measured joints nothing is felt.
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
def update_odometry(planner: PlannerState) -> int:
    """Update the odometry with the feet planned to stand in this tick; return 1, or 0 if the legs feel nothing.

    While the robot is lifted its feet show no motion of the body, only the load that they carry.
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
