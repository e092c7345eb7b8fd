"""From command and measured motion to how the standing feet go back, how the body turns, and where feet are to land."""

from ..body.axes import Pose, Twist
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import Ints, const, hot
from .ground import climbs
from .state import Trot

_TURN_MAX = const(16383)  # 2^-18 rad / tick
_TILT_MAX = const(8191)  # brad, 45 deg
_LEAN_MAX = const(8191)  # rad Q14: feet are not turned level by more than 29 deg
_BRAD_18 = const(25736)  # 2 pi / 65536 * 2^18 in Q10
_SPEED_MAX = const(262143)  # lf / tick
_HEADING_MAX = const(131071)  # 2^-18 rad, half a radian
_OFF_MAX = const(65535)  # lu
_LATE_Q10 = const(8)  # 0.008 of the leg: how far from rest all feet together may be
_MORE_Q8 = const(77)  # 0.3 of the speed: the most that is added to reach it


@hot
def steer(params: Params, walk: Trot, speed: Twist, turned: Ints, pose: Pose) -> None:
    """Write the speeds of the feet for a commanded one (lf / tick, yaw18 / tick) and what was measured.

    A round foot's centre goes slower than the body. Heading: turned back by what was turned wrong; the pose's yaw is
    turned to. The feet of one that is not to move stay. Intermediates: 2^18 * 2^10.
    """
    state = walk.state
    setup = params.trot
    for axis in range(2):
        told = saturate(speed[axis], -_SPEED_MAX, _SPEED_MAX)
        foot = (told >> 5) * setup.rolling_q15 >> 10
        state.foot_speed[axis] = foot
        reach_speed(params, walk, axis, told)
        state.drive[axis] = foot + (state.drift_q8[axis] >> 8)
        more = saturate(state.seen[axis] - foot, -_SPEED_MAX, _SPEED_MAX)
        further = (more >> 6) * setup.capture_q8 >> 10
        state.capture[axis] = saturate(further, -setup.capture_max, setup.capture_max)
    wait_for_feet(params, walk, pose)
    turn = speed.wz + ((pose.yaw - walk.posed.yaw) * _BRAD_18 >> 10)
    walk.posed.yaw = pose.yaw
    if walk.wish.moving:
        missed = turn - saturate(turned[2], -_HEADING_MAX, _HEADING_MAX)
        state.heading_18 = saturate(state.heading_18 + missed, -_HEADING_MAX, _HEADING_MAX)
        turn += state.heading_18 * setup.heading_q16 >> 16
    state.turn_18 = saturate(turn, -_TURN_MAX, _TURN_MAX)
    if walk.wish.moving == 0:
        for axis in range(2):
            state.drive[axis] = 0
            state.drift_q8[axis] = 0


@hot
def reach_speed(params: Params, walk: Trot, axis: int, told: int) -> None:
    """Move what is added to the commanded speed, lf / tick along one axis, by what the odometry misses of it.

    Who misses more than may be added is pushed or held: then what is added stays as it is. While swings are high
    nothing is added: what held the body up would make it lunge once it is over. Intermediates: 2^18 * 2^12.
    """
    state = walk.state
    setup = params.trot
    if state.known == 0 or state.high_left:
        state.drift_q8[axis] = 0
        return
    missed = saturate(told - walk.odometry.speed[axis], -_SPEED_MAX, _SPEED_MAX)
    if told < 0:
        told = -told
    most = (told * _MORE_Q8 >> 8) + setup.drift_least
    if missed <= most and missed >= -most:
        drift = state.drift_q8[axis] + (missed * setup.drift_q15 >> 7)
        state.drift_q8[axis] = saturate(drift, -most << 8, most << 8)


@hot
def wait_for_feet(params: Params, walk: Trot, pose: Pose) -> None:
    """While swings are high the body waits for feet that stay behind; for feet that are ahead it does not hurry.

    It would go on over feet that an edge holds up, and its trunk come down on the edge. What all feet together are
    too far behind is taken back in an eighth of a cycle, but the body goes back only where the ground climbs: on the
    level a late bus alone would send it back. Intermediates: 2^16 * 2^13.
    """
    state = walk.state
    if state.high_left == 0:
        return
    total = 0
    for leg in range(LEGS):
        rest = params.legs[leg].rest
        total += (walk.feet[leg * 3] >> LF_BITS) - rest.x
    most = params.leg_length * _LATE_Q10 >> 10
    off = saturate((total >> 2) + pose.x - params.com_x, -_OFF_MAX, _OFF_MAX)
    slow = (saturate(off, -most, most) - off) * params.trot.raise_q16 >> 4
    ahead = state.foot_speed.x
    if (ahead > 0 and slow < 0) or (ahead < 0 and slow > 0):
        return
    drive = state.drive.x - slow
    if ((ahead > 0 and drive < 0) or (ahead < 0 and drive > 0)) and climbs(params, walk) == 0:
        drive = 0
    state.drive.x = drive


@hot
def lean(params: Params, walk: Trot, tilt: Ints, turned: Ints, pose: Pose) -> None:
    """Take roll and pitch, brad, and the body's pose; write the tilt to come and the turns that level it.

    Tilts are limited to 45 deg. A changing pose moves the standing feet along, and turns the body where nothing levels
    it. Intermediates: 2^13 * 2^15.3.
    """
    state = walk.state
    setup = params.trot
    posed = walk.posed
    for axis in range(2):
        angle = saturate(tilt[axis], -_TILT_MAX, _TILT_MAX)
        rate = saturate(turned[axis], -_TURN_MAX, _TURN_MAX)
        now_18 = angle * _BRAD_18 >> 10
        state.tilt_q14[axis] = saturate(now_18 >> 4, -_LEAN_MAX, _LEAN_MAX)
        then_q14 = saturate(now_18 + (rate * setup.tilt_lead_q8 >> 8) >> 4, -_LEAN_MAX, _LEAN_MAX)
        further = pose[axis + 3] - posed[axis + 3]
        posed[axis + 3] = pose[axis + 3]
        if walk.wish.balance and state.known:
            wrong = saturate(angle - pose[axis + 3], -_TILT_MAX, _TILT_MAX)
            turn = -(wrong * setup.level_q12 >> 12)
        else:
            turn = saturate(further, -_TILT_MAX, _TILT_MAX) * _BRAD_18 >> 10
        turn = saturate(turn, -_TURN_MAX, _TURN_MAX)
        if axis:
            state.pitch_q14 = then_q14
            state.pitch_18 = turn
        else:
            state.roll_q14 = then_q14
            state.roll_18 = turn
        state.drive[axis] += pose[axis] - posed[axis] << LF_BITS
        posed[axis] = pose[axis]


@hot
def rise(params: Params, walk: Trot, pose: Pose) -> None:
    """Write how fast the body rises, with its pose and to its height above the standing feet."""
    state = walk.state
    total = 0
    for leg in range(LEGS):
        if walk.stands[leg]:
            total += walk.feet[leg * 3 + 2] >> LF_BITS
    state.rise = 0
    if state.standing:
        low = saturate(params.trot.height + pose.z + total // state.standing, -16383, 16383)
        state.rise = (low * params.trot.raise_q16 >> 8) + (pose.z - walk.posed.z << LF_BITS)
    walk.posed.z = pose.z
