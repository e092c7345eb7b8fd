"""The crawl's constants for one robot at one rate: times in ticks, lengths in parts of the leg.

Lengths and speeds were found on Caramelo (leg 240 mm, in MuJoCo, on steps of 2 to 6 cm) and are given here in
mm of such a leg; another robot gets them in proportion to its leg. Forces are parts of the own weight.
"""

from .crawl_layout import (
    K_A_DOWN,
    K_A_UP,
    K_ACC,
    K_ADVANCE,
    K_ADVANCE_VOID,
    K_AHEAD,
    K_ARM_X,
    K_ARM_Y,
    K_BACK,
    K_BODY_TICKS,
    K_BODY_V,
    K_BRAKE,
    K_CLEAR,
    K_COM_X,
    K_COM_Z,
    K_DEEPEST,
    K_FADE,
    K_FAR,
    K_FORCE,
    K_HEIGHT,
    K_HIGH,
    K_HIT,
    K_HIT_AFTER,
    K_HIT_BACK,
    K_HIT_LAG,
    K_KI,
    K_LAG,
    K_LATE,
    K_LIFT_FRONT,
    K_LIFT_REAR,
    K_LIMIT_A,
    K_LIMIT_X,
    K_LOW,
    K_MARGIN,
    K_MOVE_PACE,
    K_MOVE_TICKS,
    K_NEAR,
    K_NEAR_PRINT,
    K_PACE,
    K_PLANAR,
    K_RAISE,
    K_RATE,
    K_REACH,
    K_REACH_SWING,
    K_REBASE,
    K_ROLL_Q8,
    K_SETTLE,
    K_SHARE,
    K_SHARE_TICKS,
    K_SHIN,
    K_SHIN_RAISE,
    K_SLIP_FAR,
    K_SLIP_XY,
    K_SLIP_Z,
    K_STRIDE,
    K_TALL,
    K_TARE_FAST,
    K_TARE_IN,
    K_TARE_SKIP,
    K_TARE_SLOW,
    K_TARE_TICKS,
    K_TOO_HIGH,
    K_TOUCH_TICKS,
    K_V_FRONT,
    K_V_QUICK,
    K_V_REAR,
    K_V_SLOW,
    K_V_TARE,
    K_V_TOP,
    K_V_UP,
    K_VOID,
    K_WARP,
    K_WARP_MAX,
    K_WARP_TICKS,
    K_WARP_V,
    K_WEIGHT,
)
from .fixed import cos_q15, hypot, isqrt
from .params import (
    FR,
    LEGS,
    LF_BITS,
    RR,
    Params,
)
from .record import copy

_LEG_MM = 240  # the leg the lengths below belong to

# (setting, mm): all measured in simulation unless a reason is given
_LENGTHS = (
    (K_TALL, 22),
    (K_MARGIN, 28),
    (K_AHEAD, 18),
    (K_COM_Z, -9),
    (K_LIFT_FRONT, 65),  # unknown ground: the highest step, 60 mm, and 5
    (K_LIFT_REAR, 35),  # known ground: odometry and sag
    (K_NEAR_PRINT, 12),
    (K_DEEPEST, 85),
    (K_HIT, 12),
    (K_HIGH, 18),  # beyond 10 deg of slope over one stride (13 mm) and 4 mm of sag
    (K_VOID, 24),
    (K_ADVANCE, 25),  # a foot on a corner stands at most a foot's radius before it
    (K_ADVANCE_VOID, 45),  # the shin slopes 33-45 deg behind the foot: 60 mm deep needs 45 mm
    (K_BACK, 28),
    (K_HIT_BACK, 20),
    (K_RAISE, 20),
    (K_CLEAR, 10),
    (K_SHIN, 9),
    (K_SHIN_RAISE, 25),
    (K_TOO_HIGH, 65),
)
# (setting, mm / s)
_SPEEDS = (
    (K_BODY_V, 60),
    (K_V_UP, 240),
    (K_V_TOP, 20),
    (K_MOVE_PACE, 156),  # the quintic's peak, 1.6 times that, at 0.25 m/s
    (K_V_TARE, 20),
    (K_V_FRONT, 100),
    (K_V_REAR, 192),
    (K_V_SLOW, 60),
    (K_V_QUICK, 72),
    (K_WARP, 17),  # 0.8 mm/s per newton
    (K_WARP_V, 30),
)
# (setting, ms)
_TIMES = (
    (K_BODY_TICKS, 250),
    (K_SETTLE, 60),
    (K_SHARE_TICKS, 300),
    (K_MOVE_TICKS, 120),
    (K_TARE_TICKS, 140),
    (K_TARE_SKIP, 60),
    (K_TOUCH_TICKS, 60),
    (K_HIT_AFTER, 100),
    (K_HIT_LAG, 20),
    (K_LATE, 60),
    (K_WARP_TICKS, 1500),
)
# (setting, time constant in ms)
_GAINS = (
    (K_FORCE, 20),  # joint speeds come as counts a tick: coarse at high rates
    (K_LAG, 60),  # bus delay and servo: the body follows by this much
    (K_KI, 333),
    (K_LOW, 100),
    (K_FADE, 150),
    (K_TARE_IN, 67),
    (K_TARE_SLOW, 400),
    (K_TARE_FAST, 100),
    (K_SLIP_XY, 1000),
    (K_SLIP_Z, 3000),
    (K_SLIP_FAR, 200),
    (K_WEIGHT, 2000),
)


def crawl_setup(params: Params, settings, limbs: Params):
    """Fill the crawl's settings (K_SIZE) and ``limbs``, the robot's block with its legs' usable reach; return 0.

    ``limbs`` is params with LEG_REACH and LEG_NEAR moved in to where the calf's limits end. For set-up: every
    value in it stays within 30 bits, nothing is called per tick.
    """
    rate = params.rate_hz
    leg = params.legs[0].thigh_length + params.legs[0].calf_length
    settings[K_RATE] = rate
    for at, mm in _LENGTHS:
        settings[at] = leg * mm // _LEG_MM
    for at, mm_s in _SPEEDS:
        settings[at] = max(1, (leg * mm_s // _LEG_MM << LF_BITS) // rate)
    for at, ms in _TIMES:
        settings[at] = max(1, (ms * rate + 500) // 1000)
    for at, ms in _GAINS:
        settings[at] = min(32768, max(1, (32768 * 1000 // ms + rate // 2) // rate))
    accelerations(settings, leg, rate)
    body_shape(params, settings, leg)
    bend_limits(params, settings, limbs)
    settings[K_PLANAR] = 0 if params.lateral_q12 else 1
    settings[K_ROLL_Q8] = params.foot_radius * 710 // 113
    settings[K_SHARE] = max(1, 4096 // settings[K_SHARE_TICKS])
    settings[K_WARP_MAX] = leg * 40 // _LEG_MM << LF_BITS
    settings[K_FAR] = leg * 8 // _LEG_MM << LF_BITS
    settings[K_LIMIT_X] = leg * 30 // _LEG_MM << LF_BITS
    settings[K_LIMIT_A] = 2086 << 8  # 0.2 rad
    settings[K_REBASE] = leg << LF_BITS - 1
    return 0


def accelerations(settings, leg, rate):
    """Fill in accelerations, found as mm / s^2 of a leg of 240 mm: 600 body, 3000 up, 500 down, 2500 braking."""
    settings[K_ACC] = leg * 600 // _LEG_MM
    settings[K_A_UP] = max(1, (leg * 3000 // _LEG_MM << LF_BITS) // rate // rate)
    settings[K_A_DOWN] = max(1, (leg * 500 // _LEG_MM << LF_BITS) // rate // rate)
    settings[K_BRAKE] = max(2, (leg * 5000 // _LEG_MM << LF_BITS) // rate // rate)


def body_shape(params: Params, settings, leg):
    """Fill in what depends on the hips: the stride of a third of their distance, the corners, the centre of mass."""
    front = params.legs[FR]
    length = front.hip[0] - params.legs[RR].hip[0]
    settings[K_STRIDE] = min(length // 3, leg * 90 // _LEG_MM)
    settings[K_PACE] = settings[K_STRIDE] << LF_BITS - 2
    settings[K_ARM_X] = length // 2
    width = front.hip[1] - front.hip_length * -1
    settings[K_ARM_Y] = -width if width < 0 else width
    settings[K_COM_X] = params.com_x


def bend_limits(params: Params, settings, limbs: Params):
    """Copy ``params`` to ``limbs`` with the reach that the calves' limits leave; fill in the planned reach.

    A trot's foot is put no higher than half way from the hip's offset to the shortest leg below the hip (LEG_CLEAR):
    there its leg's direction turns by no more than the foot's way over that depth. What the joints reach above it
    lies at the ends of thigh and calf.

    By the cosine rule, L2^2 + L3^2 + 2 L2 L3 cos q3 at both limits of q3. The hips are carried at 0.865 of the
    straightest leg (185 mm of Caramelo's 214): the straighter the knees, the less they carry.
    """
    copy(params, limbs)
    shortest = 32767
    for leg in range(LEGS):
        base = limbs.legs[leg]
        low = base.lowest[2]
        high = base.highest[2]
        straight = high if base.knee < 0 else low
        bent = low if base.knee < 0 else high
        far = bent_length(base.thigh_length, base.calf_length, straight)
        near = bent_length(base.thigh_length, base.calf_length, bent)
        side = base.hip_length
        base.longest = min(hypot(far, side), base.longest)
        base.shortest = max(hypot(near, side) + 1, base.shortest)
        base.clearance = -(base.shortest + abs(side) >> 1)
        shortest = min(shortest, far)
        settings[K_NEAR] = max(settings[K_NEAR] if leg else 0, near + near // 72)
    settings[K_HEIGHT] = shortest * 173 // 200
    settings[K_REACH] = shortest - shortest // 49
    settings[K_REACH_SWING] = shortest - shortest // 240


def bent_length(l2, l3, calf_brad):
    """Return the distance from thigh joint to foot in lu of a leg bent by ``calf_brad``; error at most 4 lu."""
    half_sq = (l2 * l2 >> 2) + (l3 * l3 >> 2) + ((l2 * l3 >> 15) * cos_q15(calf_brad) >> 1)
    return 2 * isqrt(half_sq)
