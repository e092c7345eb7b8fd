"""The slope of the ground under the stance feet, on which the next feet are to touch down.

Only their plane is remembered, not single footholds: a foot that meets an edge tips the trunk, and a memory would keep
the tip; a slope lasts.
"""

from ..body.params import LEGS, Params
from ..num.fixed import saturate
from ..runtime import const, hot
from .state import Trot

_MOST_Q20 = const(314573)  # steepest slope: 0.3, 17 deg
_STEEP_Q20 = const(104858)  # 0.1: half the slope of stairs with steps of 0.17 of the leg
_STEP_Q14 = const(8191)
_UNEVEN_Q10 = const(98)  # 0.006 of the leg, in lu Q4; 0.002 on a slope of 10 deg, 0.009 to 0.04 on stairs (measured)
_ROUGH_Q10 = const(41)  # 0.0025 of the leg, in lu Q4; at most 0.0013 on level ground, 0.003 on stones (seven robots)
_TILTED_Q14 = const(1000)  # 3.5 deg; at most 3 in slow walks on stones of 12 mm
_FAR = const(32767)


@hot
def update_slope(params: Params, trot: Trot) -> None:
    """Update the slope from the measured stance feet, in level axes."""
    middle_x = 0
    middle_y = 0
    middle_z = 0
    count = 0
    for leg in range(LEGS):
        if trot.stance[leg]:
            foot = trot.measured.legs[leg]
            z = level_z(trot, leg)
            middle_x += foot.x
            middle_y += foot.y
            middle_z += z
            trot.heights[leg] = z
            count += 1
    if count < 2:
        return
    update_plane(params, trot, count, middle_x // count, middle_y // count, middle_z // count)


@hot
def update_plane(params: Params, trot: Trot, count: int, middle_x: int, middle_y: int, middle_z: int) -> None:
    """Update the slope from the ``count`` stance feet about their middle, lu in level axes. Part of update_slope.

    Each diagonal shows a mixture of both slopes, the other one a different mixture: together they show both. This is
    the step of normalized least mean squares. Intermediates: 4 * 32767 * 1023, 8 * 1023^2, 2^13 * 2^15.
    """
    along_x = 0
    along_y = 0
    square = 0
    uneven = 0
    for leg in range(LEGS):
        if trot.stance[leg]:
            foot = trot.measured.legs[leg]
            x = saturate(foot.x - middle_x, -_FAR, _FAR)
            y = saturate(foot.y - middle_y, -_FAR, _FAR)
            off = trot.heights[leg] - middle_z - ground_z(trot, x, y)
            off = saturate(off, -_FAR, _FAR)
            if off < 0:
                uneven -= off
            else:
                uneven += off
            x >>= 5
            y >>= 5
            along_x += off * x
            along_y += off * y
            square += x * x + y * y
    square = (square >> 9) + 1
    correct_slope(params, trot, 0, along_x // square)
    correct_slope(params, trot, 1, along_y // square)
    update_uneven(params, trot, uneven // count)


@hot
def correct_slope(params: Params, trot: Trot, axis: int, off_q14: int) -> None:
    """Correct one slope, within +-0.3, by a share of its error ``off_q14``, any 30 bits."""
    state = trot.state
    step = saturate(off_q14, -_STEP_Q14, _STEP_Q14) * params.trot.slope_gain_q15 >> 9
    state.slope_q20[axis] = saturate(state.slope_q20[axis] + step, -_MOST_Q20, _MOST_Q20)


@hot
def update_uneven(params: Params, trot: Trot, off: int) -> None:
    """Average how far the feet are off their plane: ``off`` in lu, 0 or more. Intermediates: 2^16 * 2^13."""
    state = trot.state
    off = saturate(off, 0, params.leg_length >> 4) << 4
    state.uneven_q4 += (off - state.uneven_q4) * params.trot.slope_gain_q15 >> 17


@hot
def slope_ahead_q20(trot: Trot) -> int:
    """Return the slope of the ground in the commanded direction, forwards or backwards, Q20 within +-0.3."""
    if trot.state.foot_speed.x < 0:
        return -trot.state.slope_q20.x
    return trot.state.slope_q20.x


@hot
def climbs(params: Params, trot: Trot) -> int:
    """Return 1 if the ground rises ahead like stairs, or like an edge with the hind feet still below it; else 0.

    There the feet have lately stood off their plane; on a slope they stand in it.
    """
    if slope_ahead_q20(trot) > _STEEP_Q20 and trot.state.uneven_q4 > params.leg_length * _UNEVEN_Q10 >> 10:
        return 1
    return 0


@hot
def off_level(tilt_q14: int) -> int:
    """Return 1 if a tilt is larger than that of a slow walk on stones, else 0."""
    if tilt_q14 > _TILTED_Q14 or tilt_q14 < -_TILTED_Q14:
        return 1
    return 0


@hot
def choose_care(params: Params, trot: Trot) -> None:
    """Note whether the robot walks with care: slowly, with low swings, where the feet lately stood off their plane.

    Then its body is levelled faster (steer.py), swings are higher (react.py), and all feet stand longer (clock.py). Not
    where it is steep, as astride an edge; not in the first 2 s, when feet stand off the plane of a slope that is not
    known; and not for 2 s after a larger tilt: with a bus later than its file says, a robot would rock itself up.
    """
    state = trot.state
    most = params.trot.careful_speed
    if state.known == 0 or off_level(state.tilt_q14.roll) or off_level(state.tilt_q14.pitch):
        state.careful = -2 * params.rate_hz
    if state.careful < -1:
        state.careful += 1
        return
    state.careful = 0
    if state.high_left or state.uneven_q4 <= params.leg_length * _ROUGH_Q10 >> 10:
        return
    going = 0
    for axis in range(2):
        slope = state.slope_q20[axis]
        speed = state.foot_speed[axis]
        if slope > _STEEP_Q20 or slope < -_STEEP_Q20 or speed > most or speed < -most:
            return
        going |= speed
    if going:
        state.careful = 1


@hot
def level_z(trot: Trot, leg: int) -> int:
    """Return the height of a measured foot in level axes, lu."""
    state = trot.state
    foot = trot.measured.legs[leg]
    return foot.z + (foot.y * state.tilt_q14.roll >> 14) - (foot.x * state.tilt_q14.pitch >> 14)


@hot
def ground_z(trot: Trot, x: int, y: int) -> int:
    """Return how much higher the ground is expected at (x, y) than below the body, lu; x, y within +-65535."""
    return (x * (trot.state.slope_q20.x >> 6) >> 14) + (y * (trot.state.slope_q20.y >> 6) >> 14)
