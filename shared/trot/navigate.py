"""Holds position and heading: the walk's reference runs ahead at the commanded speed, the robot follows.

Kept in the robot's own level axes, as the error to the reference: each tick adds what the
reference moved, takes off what the legs say the body moved, and turns with the gyro. So nothing
wraps and nothing is far away. The correction is a small part of the speed (Raibert's velocity
feedback with a position term), and feet are placed for the corrected speed.
"""

from ..body.params import LF_BITS, Params
from ..gait.steps import SPEED_SIZE, SPEED_WZ, SPEED_X, SPEED_Y
from ..num.fixed import saturate
from ..record import field, record
from ..runtime import Ints, const, hot


@record
class Navigation:
    """How far the walk's reference is ahead of the robot."""

    x: int = field("lf", "ahead, in the robot's level axes")
    y: int = field("lf", "to the left")
    yaw: int = field("yaw18", "its heading from the robot's")


_YAW_MAX = const(91750)  # yaw18, 0.35 rad: further the reference waits
_TURN_MAX = const(0x7FFF)  # yaw18 a tick, 1/8 rad


@hot
def navigate_reset(nav: Navigation) -> int:
    """Put the reference where the robot is; return 0."""
    nav.x = 0
    nav.y = 0
    nav.yaw = 0
    return 0


@hot
def follow_reference(
    params: Params, speed: Ints, moved_x: int, moved_y: int, turned_yaw18: int, yaw_known: int, nav: Navigation
) -> int:
    """Update the errors by one tick; return 0.

    speed: the reference's, 3 values within +-2^19; moved: lf, within +-2^22; turned: yaw18, limited to 1/8 rad.
    The reference waits where it would be more than a sixth of the leg's length or 0.35 rad away. Without
    yaw the heading's error is 0. Error at most 2 lf a tick while turning. Intermediates: 2^15 * 2^13.
    """
    yaw = 0
    turned = 0
    if yaw_known:
        turned = saturate(turned_yaw18, -_TURN_MAX, _TURN_MAX)
        yaw = saturate(nav.yaw + speed[SPEED_WZ] - turned, -_YAW_MAX, _YAW_MAX)
    nav.yaw = yaw
    most = (params.leg_length << LF_BITS) // 6
    x = nav.x + speed[SPEED_X] - ((speed[SPEED_Y] >> 4) * (yaw >> 4) >> 10) - moved_x
    y = nav.y + speed[SPEED_Y] + ((speed[SPEED_X] >> 4) * (yaw >> 4) >> 10) - moved_y
    x = saturate(x, -most, most)
    y = saturate(y, -most, most)
    nav.x = x + ((y >> LF_BITS) * turned >> 10)
    nav.y = y - ((x >> LF_BITS) * turned >> 10)
    return 0


@hot
def hold(params: Params, speed: Ints, sway_lu: int, nav: Navigation, drive: Ints) -> int:
    """Write the speeds to walk with into ``drive``: the reference's plus the errors times a gain, limited.

    sway: lu, within +-32767, the body's planned way to the left, which is no error. Corrections are limited to a
    fifth of the speed along x (of the starting speed if that is more), two fifths of the largest speed along
    y, three quarters of the largest turn. Returns 0. Intermediates: 2^18 * 2^11 (20 Hz, the slowest rate).
    """
    gain = params.hold_q16
    most = speed[SPEED_X]
    if most < 0:
        most = -most
    if most < params.start_speed:
        most = params.start_speed
    most = most // 5
    drive[SPEED_X] = speed[SPEED_X] + saturate((nav.x >> 4) * gain >> 12, -most, most)
    most = params.speed_max[1] * 2 // 5
    y = saturate(nav.y + (sway_lu << LF_BITS), -0x3FFFFF, 0x3FFFFF)
    drive[SPEED_Y] = speed[SPEED_Y] + saturate((y >> 4) * gain >> 12, -most, most)
    most = params.speed_max[2] * 3 // 4
    drive[SPEED_WZ] = speed[SPEED_WZ] + saturate((nav.yaw >> 4) * gain >> 12, -most, most)
    return 0


@hot
def drive_as_told(speed: Ints, drive: Ints) -> int:
    """Walk with the commanded speeds, uncorrected; return 0."""
    for axis in range(SPEED_SIZE):
        drive[axis] = speed[axis]
    return 0
