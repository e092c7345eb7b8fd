"""Where the planned feet go in a tick: stance feet with the ground, swing feet to their footholds.

The body does not track a pose over its feet: stance feet go back at the body's wanted speed, turn against its turn, and
sink as it rises. An error made in a stance is gone with the next swing.
"""

from ..body.axes import Pose
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import cos_q15, mul_q15, saturate, sin_q15
from ..runtime import const, hot
from .ground import ground_z
from .state import Trot

_PER_TURN_Q15 = const(5215)  # 1 / (2 pi)
_FAR = const(32767)
_WIDE = const(65535)
_HALF_Q15 = const(16384)
_PUSH_MAX_Q10 = const(123)  # 0.12 of the leg: how far below its measured position a stance foot is sent at most


@hot
def stand_feet(params: Params, trot: Trot) -> None:
    """Move the stance feet by one tick.

    They stay within half a leg of rest along the ground and a quarter in height, so that nothing winds up while
    somebody holds the robot tilted. Intermediates: 2 * 16383 * 32767 < 2^30.
    """
    state = trot.state
    half = params.leg_length << LF_BITS - 1
    about_x = state.roll_18
    about_y = state.pitch_18
    about_z = state.turn_18
    for leg in range(LEGS):
        if trot.stance[leg]:
            rest = params.legs[leg].rest
            foot = trot.feet.legs[leg]
            x = foot.x >> LF_BITS + 1
            y = foot.y >> LF_BITS + 1
            z = foot.z >> LF_BITS + 1
            x_lf = foot.x - state.stance_speed.x - (about_y * z - about_z * y >> 9)
            y_lf = foot.y - state.stance_speed.y - (about_z * x - about_x * z >> 9)
            z_lf = foot.z - state.rise_speed - (about_x * y - about_y * x >> 9) + limit_push(params, trot, leg)
            off_x = x_lf - (rest.x << LF_BITS)
            off_y = y_lf - (rest.y << LF_BITS)
            off_z = z_lf - (rest.z << LF_BITS) << 1
            if off_x > half or off_x < -half or off_y > half or off_y < -half or off_z > half or off_z < -half:
                x_lf += saturate(off_x, -half, half) - off_x
                y_lf += saturate(off_y, -half, half) - off_y
                z_lf += saturate(off_z, -half, half) - off_z >> 1
            foot.x = x_lf
            foot.y = y_lf
            foot.z = z_lf


@hot
def limit_push(params: Params, trot: Trot, leg: int) -> int:
    """Return by how much the goal of a stance foot is raised in this tick, lf.

    A leg that can't lift its corner of the body pushes with all its force, whichever way that points, and throws the
    body ahead. The excess over 0.12 of the leg is taken back in an eighth of a cycle. Intermediates: 2^15 * 2^13.
    """
    if trot.state.known <= params.delay_ticks:
        return 0
    over = saturate(trot.residual_z[leg] - (params.leg_length * _PUSH_MAX_Q10 >> 10), 0, _FAR)
    return over * params.trot.height_kp_q16 >> 4


@hot
def lift_off(trot: Trot, leg: int) -> None:
    """Begin the swing of ``leg``: store where it starts, turned into level axes by the tilt to come."""
    state = trot.state
    foot = trot.feet.legs[leg]
    start = trot.lift_offs.legs[leg]
    x = foot.x >> LF_BITS
    y = foot.y >> LF_BITS
    z = foot.z >> LF_BITS
    start.y = y - (z * state.roll_q14 >> 14)
    z += y * state.roll_q14 >> 14
    start.x = x + (z * state.pitch_q14 >> 14)
    start.z = z - (x * state.pitch_q14 >> 14)
    trot.swing_top[leg] = -_FAR
    trot.shortened[leg] = 0


@hot
def cycloid_way_q15(share_q15: int) -> int:
    """Return the share of its way that a foot on a cycloid has covered after a share of its time, both 0 .. 32767.

    u - sin(2 pi u) / (2 pi): no speed at either end. Error at most 2 LSB.
    """
    return saturate(share_q15 - (sin_q15(share_q15 << 1) * _PER_TURN_Q15 >> 15), 0, 32767)


@hot
def swing_feet(params: Params, trot: Trot, pose: Pose) -> None:
    """Move the swing feet by one tick.

    Along the ground a foot comes to rest before it touches down; its height is a cosine. Foothold: rest, plus the way
    for which the linear pendulum goes on at an even speed, plus the capture step for the error of the speed. All in
    level axes, then turned into the body by the tilt to come. Intermediates: 32767 * 32767 + 2^14.
    """
    setup = params.trot
    share = trot.state.swing_q15
    ahead = share * setup.ahead_rate_q13 >> 13
    if ahead > 32767:
        ahead = 32767
    way = cycloid_way_q15(ahead)
    down = cycloid_way_q15(share)
    up = 32767 - cos_q15(share << 1) >> 1
    low = -setup.height - pose.z
    for leg in range(LEGS):
        if trot.stance[leg] == 0:
            if trot.rises_first[leg]:
                swing_foot(params, trot, leg, pose, share, held_up_way_q15(params, share))
                draw_back(params, trot, leg, share)
            else:
                swing_foot(params, trot, leg, pose, share, way)
            settle_foot(trot, leg, mul_q15(trot.apex[leg], up), low, down)


@hot
def held_up_way_q15(params: Params, share_q15: int) -> int:
    """Return the share of its way that a held-up foot has covered after a share of its next swing, both 0 .. 32767.

    The foot rises before it goes ahead. Pressed against a riser it would be held down by friction, and would pull its
    corner of the body down instead of rising. Intermediates: 2^15 * 2^14.
    """
    setup = params.trot
    return cycloid_way_q15(saturate((share_q15 - setup.rise_first_q15) * setup.rise_first_rate_q13 >> 13, 0, 32767))


@hot
def draw_back(params: Params, trot: Trot, leg: int, share_q15: int) -> None:
    """Pull a foot that was held up back from the obstacle, in the first half of its swing. Part of swing_feet."""
    if share_q15 >= _HALF_Q15:
        return
    back = mul_q15(params.trot.draw_back, 32767 - cos_q15(share_q15 << 2) >> 1)
    if trot.state.foot_speed.x < 0:
        back = -back
    trot.feet.legs[leg].x -= back << LF_BITS


@hot
def swing_foot(params: Params, trot: Trot, leg: int, pose: Pose, share_q15: int, way_q15: int) -> None:
    """Write x and y of a swing foot, lf in level axes, into ``feet``. Part of swing_feet.

    Intermediates: 2^13 * 2^15 of a speed and a time.
    """
    state = trot.state
    setup = params.trot
    foot = trot.feet.legs[leg]
    start = trot.lift_offs.legs[leg]
    rest = params.legs[leg].rest
    x = rest.x + params.com_x - pose.x
    y = rest.y + params.com_y - pose.y
    turn_x = state.turn_18 * (y >> 1) >> 9
    turn_y = state.turn_18 * (x >> 1) >> 9
    x += state.capture.x + ((state.foot_speed.x - turn_x >> 6) * setup.neutral_q8 >> 10)
    y += state.capture.y + ((state.foot_speed.y + turn_y >> 6) * setup.neutral_q8 >> 10)
    back = saturate((state.stance_speed.x - turn_x >> 6) * setup.swing_q8 >> 10, -_FAR, _FAR)
    gap = saturate(x - start.x + back, -_FAR, _FAR)
    x = start.x + mul_q15(gap, way_q15) - mul_q15(back, share_q15)
    foot.x = x - trot.shortened[leg] << LF_BITS
    back = saturate((state.stance_speed.y + turn_y >> 6) * setup.swing_q8 >> 10, -_FAR, _FAR)
    gap = saturate(y - start.y + back, -_FAR, _FAR)
    foot.y = start.y + mul_q15(gap, way_q15) - mul_q15(back, share_q15) << LF_BITS


@hot
def settle_foot(trot: Trot, leg: int, lifted: int, low: int, down_q15: int) -> None:
    """Write the height of a swing foot and turn the foot into body axes. Part of swing_feet.

    lifted: lu above the straight line from the start to ``low``. Limited to 32767 lu in height, 65535 along the ground.
    Intermediates: 65535 * 8191.
    """
    state = trot.state
    foot = trot.feet.legs[leg]
    start_z = trot.lift_offs.legs[leg].z
    x = saturate(foot.x >> LF_BITS, -_WIDE, _WIDE)
    y = saturate(foot.y >> LF_BITS, -_WIDE, _WIDE)
    low += ground_z(trot, x, y)
    z = start_z + mul_q15(saturate(low - start_z, -_FAR, _FAR), down_q15) + lifted
    z = saturate(z, -_FAR, _FAR)
    foot.x = x - (z * state.pitch_q14 >> 14) << LF_BITS
    z += x * state.pitch_q14 >> 14
    foot.y = y + (z * state.roll_q14 >> 14) << LF_BITS
    foot.z = z - (y * state.roll_q14 >> 14) << LF_BITS
