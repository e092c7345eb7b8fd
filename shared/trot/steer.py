"""From command and measured motion to the stance feet's speed, the turn of the body, and the footholds."""

from ..body.axes import Pose, Turn, Twist
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import Ints, const, hot
from ..sense.sensed import PITCH, ROLL
from .ground import climbs
from .state import Trot

_TURN_MAX = const(16383)  # 2^-18 rad / tick
_TILT_MAX = const(8191)  # brad, 45 deg
_LEAN_MAX = const(8191)  # rad Q14: feet are not turned level by more than 29 deg
_BRAD_18 = const(25736)  # 2 pi / 65536 * 2^18 in Q10
_SPEED_MAX = const(262143)  # lf / tick
_HEADING_MAX = const(131071)  # 2^-18 rad, half a radian
_OFF_MAX = const(65535)  # lu
_LATE_Q10 = const(8)  # 0.008 of the leg: how far from rest the mean of all feet may be
_INTEGRAL_MAX_Q8 = const(77)  # 0.3 of the commanded speed: the most that is added to reach it


@hot
def steer(params: Params, trot: Trot, speed: Twist, turned: Turn, pose: Pose) -> None:
    """Write the speeds of the feet for the commanded speed (lf / tick, yaw18 / tick) and the measured motion.

    A round foot's centre goes slower than the body. The missing part of the speed is added, but not while swings are
    high: the body would lunge once it is past what held it up. An error of the heading is corrected, and a change of
    the pose's yaw is turned along. While ``command.moving`` is 0 the feet stay. Intermediates: 2^18 * 2^10.
    """
    state = trot.state
    setup = params.trot
    commanded_x = saturate(speed.vx, -_SPEED_MAX, _SPEED_MAX)
    commanded_y = saturate(speed.vy, -_SPEED_MAX, _SPEED_MAX)
    state.foot_speed.x = (commanded_x >> 5) * setup.rolling_q15 >> 10
    state.foot_speed.y = (commanded_y >> 5) * setup.rolling_q15 >> 10
    if state.known == 0 or state.high_left:
        state.speed_integral_q8.x = 0
        state.speed_integral_q8.y = 0
    else:
        integral = state.speed_integral_q8
        measured = trot.odometry.speed
        integral.x = integrate_speed(params, commanded_x, measured.x, integral.x)
        integral.y = integrate_speed(params, commanded_y, measured.y, integral.y)
    state.stance_speed.x = state.foot_speed.x + (state.speed_integral_q8.x >> 8)
    state.stance_speed.y = state.foot_speed.y + (state.speed_integral_q8.y >> 8)
    detect_push(params, trot)
    state.capture.x = capture_point(params, state.measured_speed.x - state.foot_speed.x)
    state.capture.y = capture_point(params, state.measured_speed.y - state.foot_speed.y)
    if state.high_left:
        wait_for_feet(params, trot, pose)
    turn = speed.wz + ((pose.yaw - trot.last_pose.yaw) * _BRAD_18 >> 10)
    trot.last_pose.yaw = pose.yaw
    if trot.command.moving:
        error = turn - saturate(turned.z, -_HEADING_MAX, _HEADING_MAX)
        state.heading_error_18 = saturate(state.heading_error_18 + error, -_HEADING_MAX, _HEADING_MAX)
        turn += state.heading_error_18 * setup.heading_kp_q16 >> 16
    state.turn_18 = saturate(turn, -_TURN_MAX, _TURN_MAX)
    if trot.command.moving == 0:
        state.stance_speed.x = 0
        state.stance_speed.y = 0
        state.speed_integral_q8.x = 0
        state.speed_integral_q8.y = 0


@hot
def detect_push(params: Params, trot: Trot) -> None:
    """Write whether the body has been pushed: it is faster than commanded, by more than walking makes it.

    A body that becomes too fast while swings are high has been thrown by an edge; it counts as pushed if its drives can
    hurry such swings. A body held up by an edge is slower than commanded, so a push against the way only counts once
    the body goes backwards.
    """
    state = trot.state
    most = params.trot.pushed_speed
    before = state.pushed
    state.pushed = 0
    ahead = overspeed(state.measured_speed.x, state.foot_speed.x)
    if ahead <= most and overspeed(state.measured_speed.y, state.foot_speed.y) <= most:
        return
    if before or (state.high_left and params.trot.hurries_high):
        state.pushed = 2
    elif state.high_left == 0:
        state.pushed = 1


@hot
def overspeed(measured: int, commanded: int) -> int:
    """Return by how much a measured speed is larger than the commanded one, regardless of their signs."""
    if measured < 0:
        measured = -measured
    if commanded < 0:
        commanded = -commanded
    return measured - commanded


@hot
def capture_point(params: Params, excess: int) -> int:
    """Return the capture step: how much further on a foot is to land for a speed ``excess`` too high, lu for lf / tick.

    Intermediates: 2^12 * 2^15.
    """
    setup = params.trot
    further = (saturate(excess, -_SPEED_MAX, _SPEED_MAX) >> 6) * setup.capture_q8 >> 10
    return saturate(further, -setup.capture_max, setup.capture_max)


@hot
def integrate_speed(params: Params, commanded: int, measured: int, integral_q8: int) -> int:
    """Return what is added to the commanded speed along one axis, integrated by one tick.

    Both speeds in lf / tick, the measured one is the odometry's; integral_q8: what is added, lf / tick Q8. If more is
    missing than may be added, the robot is pushed or held: then what is added stays as it is. Intermediates:
    2^18 * 2^12.
    """
    error = saturate(commanded - measured, -_SPEED_MAX, _SPEED_MAX)
    if commanded < 0:
        commanded = -commanded
    most = (commanded * _INTEGRAL_MAX_Q8 >> 8) + params.trot.speed_integral_least
    if error > most or error < -most:
        return integral_q8
    integral_q8 += error * params.trot.speed_ki_q15 >> 7
    most <<= 8
    return saturate(integral_q8, -most, most)


@hot
def wait_for_feet(params: Params, trot: Trot, pose: Pose) -> None:
    """While swings are high the body waits for feet that stay behind; it does not hurry for feet that are ahead.

    Otherwise it would go on over feet that an edge holds up, and its trunk would come down on the edge. If the mean of
    all feet is too far behind, the excess is taken back in an eighth of a cycle, but the body only goes back where the
    ground climbs: on the level the bus delay alone would send it back. Intermediates: 2^16 * 2^13.
    """
    state = trot.state
    total = 0
    for leg in range(LEGS):
        rest = params.legs[leg].rest
        total += (trot.feet.legs[leg].x >> LF_BITS) - rest.x
    most = params.leg_length * _LATE_Q10 >> 10
    off = saturate((total >> 2) + pose.x - params.com_x, -_OFF_MAX, _OFF_MAX)
    slow = (saturate(off, -most, most) - off) * params.trot.height_kp_q16 >> 4
    ahead = state.foot_speed.x
    if (ahead > 0 and slow < 0) or (ahead < 0 and slow > 0):
        return
    speed = state.stance_speed.x - slow
    if ((ahead > 0 and speed < 0) or (ahead < 0 and speed > 0)) and climbs(params, trot) == 0:
        speed = 0
    state.stance_speed.x = speed


@hot
def level_body(params: Params, trot: Trot, tilt: Ints, turned: Turn, pose: Pose) -> None:
    """Take roll and pitch, brad, and the body's pose; write the tilt to come and the turns that level the body.

    Tilts are limited to 45 deg. A change of the pose moves the stance feet, and turns the body if nothing levels it.
    Intermediates: 2^13 * 2^15.3.
    """
    state = trot.state
    posed = trot.last_pose
    roll = saturate(tilt[ROLL], -_TILT_MAX, _TILT_MAX)
    pitch = saturate(tilt[PITCH], -_TILT_MAX, _TILT_MAX)
    state.tilt_q14.roll = predict_tilt(params, roll, 0)
    state.tilt_q14.pitch = predict_tilt(params, pitch, 0)
    state.roll_q14 = predict_tilt(params, roll, turned.x)
    state.pitch_q14 = predict_tilt(params, pitch, turned.y)
    if trot.command.balance and state.known:
        kp_q12 = params.trot.level_kp_q12
        if state.careful > 0:
            kp_q12 = params.trot.careful_kp_q12
            roll += saturate(turned.x, -_TURN_MAX, _TURN_MAX) * params.trot.careful_lead_q12 >> 12
            pitch += saturate(turned.y, -_TURN_MAX, _TURN_MAX) * params.trot.careful_lead_q12 >> 12
        state.roll_18 = turn_level(kp_q12, roll - pose.roll)
        state.pitch_18 = turn_level(kp_q12, pitch - pose.pitch)
    else:
        state.roll_18 = turn_along(pose.roll - posed.roll)
        state.pitch_18 = turn_along(pose.pitch - posed.pitch)
    state.stance_speed.x += pose.x - posed.x << LF_BITS
    state.stance_speed.y += pose.y - posed.y << LF_BITS
    posed.x = pose.x
    posed.y = pose.y
    posed.roll = pose.roll
    posed.pitch = pose.pitch


@hot
def predict_tilt(params: Params, tilt: int, turned: int) -> int:
    """Return roll or pitch, rad Q14, as foreseen: now ``tilt`` brad, and turning on by ``turned`` for the tilt's lead.

    turned: 2^-18 rad in a tick, 0 for the tilt as it is.
    """
    if turned > _TURN_MAX or turned < -_TURN_MAX:
        turned = saturate(turned, -_TURN_MAX, _TURN_MAX)
    then_q14 = (tilt * _BRAD_18 >> 10) + (turned * params.trot.tilt_lead_q8 >> 8) >> 4
    if then_q14 > _LEAN_MAX or then_q14 < -_LEAN_MAX:
        return saturate(then_q14, -_LEAN_MAX, _LEAN_MAX)
    return then_q14


@hot
def turn_level(kp_q12: int, wrong: int) -> int:
    """Return this tick's turn about x or y, 2^-18 rad, to level a body that is tilted ``wrong`` brad too far.

    kp_q12: 2^-18 rad / brad Q12, below 2^17. Intermediates: 2^13 * 2^17.
    """
    wrong = saturate(wrong, -_TILT_MAX, _TILT_MAX)
    return saturate(-(wrong * kp_q12 >> 12), -_TURN_MAX, _TURN_MAX)


@hot
def turn_along(further: int) -> int:
    """Return this tick's turn, 2^-18 rad, of a body that nothing levels and whose pose turned by ``further``, brad."""
    return saturate(saturate(further, -_TILT_MAX, _TILT_MAX) * _BRAD_18 >> 10, -_TURN_MAX, _TURN_MAX)


@hot
def rise(params: Params, trot: Trot, pose: Pose) -> None:
    """Write how fast the body rises: with its pose, and towards its height above the stance feet."""
    state = trot.state
    total = 0
    for leg in range(LEGS):
        if trot.stance[leg]:
            total += trot.feet.legs[leg].z >> LF_BITS
    state.rise_speed = 0
    if state.standing:
        low = saturate(params.trot.height + pose.z + total // state.standing, -16383, 16383)
        state.rise_speed = (low * params.trot.height_kp_q16 >> 8) + (pose.z - trot.last_pose.z << LF_BITS)
    trot.last_pose.z = pose.z
