"""Trot and crawl take over from each other: when, and so that no joint goal jumps.

The crawl starts from the measured joints, wherever the feet are. The trot gets the crawl's feet as its
footholds; what its goals then differ by (height, lead, tilt) fades over half a second.
"""

from .command import C_SPEED
from .crawl_even import Evenness
from .crawl_map import Map
from .crawl_pose import BodyPath
from .fixed import cos_q15, saturate, sin_q15
from .params import JOINTS, LEGS, LF_BITS, Params
from .runtime import Ints, const, hot
from .steps import STEP_SIZE, STEP_TICK, STEP_TICKS, STEP_TO_Z, STEP_X, STEP_Y, STEP_Z

# Why the gait was changed
REASON_NONE = const(0)
REASON_BEHIND = const(1)  # held up: the trot fell behind its reference
REASON_COMMAND = const(2)  # the driver wants it so, or a way the crawl cannot go
REASON_EVEN = const(3)  # the ground has been even for a body's length: back to the trot

F_LEFT = const(0)  # ticks to go; -1: the jump is still to be taken
F_TICKS = const(1)
F_JUMP = const(2)  # 12 brad
FADE_SIZE = const(14)

LEGS_EVEN = const(16)  # landings on even ground: the hind feet are then past where the front feet began


@hot
def straight_on(params: Params, command: Ints) -> int:
    """Return 1 if the command is one the crawl can follow: forwards, hardly sideways, hardly turning; else 0."""
    ahead = command[C_SPEED]
    aside = command[C_SPEED + 1]
    turn = saturate(command[C_SPEED + 2], -0xFFFFF, 0xFFFFF) * 4
    if ahead <= 0 or aside > ahead or aside < -ahead:
        return 0
    if turn > params.speed_max[2] or turn < -params.speed_max[2]:
        return 0
    return 1


@hot
def ground_even(even: Evenness) -> int:
    """Return 1 when all footholds have been even and found at once for four strides, a body's length; else 0."""
    if even.even_steps >= LEGS_EVEN:
        return 1
    return 0


@hot
def steps_from_crawl(params: Params, map: Map, path: BodyPath, ahead_lu: int, sway_lu: int, steps: Ints) -> int:
    """Write the crawl's feet into the trot's footholds, level and at rest height; return 0.

    A foothold is where the foot is from the crawl's wanted body, turned back by its heading, plus the trot's
    lead and sway (lu, within 32767), which its pose adds again. Feet within 32767 lu.
    Intermediates: 2 * 32767 * 16384 = 2^30 - 2^15.
    """
    yaw = path.wanted[5] >> LF_BITS
    cosine = cos_q15(yaw) + 1 >> 1
    sine = sin_q15(yaw) + 1 >> 1
    for leg in range(LEGS):
        at = leg * STEP_SIZE
        x = saturate(map.feet[leg * 3] - path.wanted[0] >> LF_BITS, -32767, 32767)
        y = saturate(map.feet[leg * 3 + 1] - path.wanted[1] >> LF_BITS, -32767, 32767)
        steps[at + STEP_X] = (x * cosine + y * sine >> 14) + ahead_lu << LF_BITS
        steps[at + STEP_Y] = (y * cosine - x * sine >> 14) + sway_lu << LF_BITS
        rest_z = params.legs[leg].rest[2]
        steps[at + STEP_Z] = rest_z
        steps[at + STEP_TO_Z] = rest_z
        steps[at + STEP_TICKS] = 0
        steps[at + STEP_TICK] = 0
    return 0


@hot
def fade_start(params: Params, fade: Ints, joints: Ints) -> int:
    """Keep the goals sent last (12 brad): the next ones are to go on from there; return the ticks of the fade."""
    for joint in range(JOINTS):
        fade[F_JUMP + joint] = joints[joint]
    fade[F_LEFT] = -1
    fade[F_TICKS] = (params.rate_hz >> 1) + 1
    return fade[F_TICKS]


@hot
def fade_out(fade: Ints, joints: Ints) -> int:
    """Add what is left of the jump to the goals (12 brad); return the ticks to go. Exact to 1 brad."""
    if fade[F_LEFT] < 0:
        for joint in range(JOINTS):
            fade[F_JUMP + joint] = saturate(fade[F_JUMP + joint] - joints[joint], -65535, 65535)
        fade[F_LEFT] = fade[F_TICKS]
    if fade[F_LEFT] > 0:
        for joint in range(JOINTS):
            left = fade[F_JUMP + joint] * fade[F_LEFT] // fade[F_TICKS]
            joints[joint] = saturate(joints[joint] + left, -32768, 32767)
        fade[F_LEFT] -= 1
    return fade[F_LEFT]
