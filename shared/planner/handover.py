"""Trot and crawl take over from each other: when, and so that no joint goal jumps.

The crawl starts from the measured joints, wherever the feet are. The trot gets the crawl's feet as its
footholds; what its goals then differ by (height, lead, tilt) fades over half a second.
"""

from ..body.params import JOINTS, LEGS, LF_BITS, Params
from ..crawl.map import Map
from ..crawl.pose import BodyPath
from ..gait.steps import Steps
from ..gait.table import MOVER_TABLE
from ..num.fixed import cos_q15, saturate, sin_q15
from ..record import field, record, vector
from ..runtime import Ints, const, hot
from .command import Command

# Why the gait was changed
REASON_NONE = const(0)
REASON_BEHIND = const(1)  # held up: the trot fell behind its reference
REASON_COMMAND = const(2)  # the driver wants it so, or a way the crawl cannot go
REASON_EVEN = const(3)  # the ground has been even for a body's length: back to the trot
REASON_HELD = const(4)  # the fast trot's swings are held up again and again


@record
class Fade:
    """What joint goals still differ from those of the gait before, fading out."""

    left: int = field("ticks", "to go; -1: the jump is still to be taken")
    ticks: int = field("ticks", "the whole fade")
    jump: Ints = vector(JOINTS, "brad", "by which the first goals differed; until it is taken, the goals sent last")


@hot
def exchanges(mover: int) -> int:
    """Return 1 if the gaits of ``mover`` are walked by a trot and the crawl in turn, 0 if by a table alone."""
    if mover == MOVER_TABLE:
        return 0
    return 1


@hot
def straight_on(params: Params, command: Command) -> int:
    """Return 1 if the command is one the crawl can follow: forwards, hardly sideways, hardly turning; else 0."""
    ahead = command.speed[0]
    aside = command.speed[1]
    turn = saturate(command.speed[2], -0xFFFFF, 0xFFFFF) * 4
    if ahead <= 0 or aside > ahead or aside < -ahead:
        return 0
    if turn > params.speed_max[2] or turn < -params.speed_max[2]:
        return 0
    return 1


@hot
def steps_from_crawl(params: Params, map: Map, path: BodyPath, ahead_lu: int, sway_lu: int, steps: Steps) -> int:
    """Write the crawl's feet into the trot's footholds, level and at rest height; return 0.

    A foothold is where the foot is from the crawl's wanted body, turned back by its heading, plus the trot's
    lead and sway (lu, within 32767), which its pose adds again. Feet within 32767 lu.
    Intermediates: 2 * 32767 * 16384 = 2^30 - 2^15.
    """
    yaw = path.wanted[5] >> LF_BITS
    cosine = cos_q15(yaw) + 1 >> 1
    sine = sin_q15(yaw) + 1 >> 1
    for leg in range(LEGS):
        step = steps.legs[leg]
        x = saturate(map.feet[leg * 3] - path.wanted[0] >> LF_BITS, -32767, 32767)
        y = saturate(map.feet[leg * 3 + 1] - path.wanted[1] >> LF_BITS, -32767, 32767)
        step.x = (x * cosine + y * sine >> 14) + ahead_lu << LF_BITS
        step.y = (y * cosine - x * sine >> 14) + sway_lu << LF_BITS
        rest_z = params.legs[leg].rest[2]
        step.z = rest_z
        step.to_z = rest_z
        step.ticks = 0
        step.tick = 0
    return 0


@hot
def fade_start(params: Params, fade: Fade, joints: Ints) -> int:
    """Keep the goals sent last (12 brad): the next ones are to go on from there; return the ticks of the fade."""
    for joint in range(JOINTS):
        fade.jump[joint] = joints[joint]
    fade.left = -1
    fade.ticks = (params.rate_hz >> 1) + 1
    return fade.ticks


@hot
def fade_out(fade: Fade, joints: Ints) -> int:
    """Add what is left of the jump to the goals (12 brad); return the ticks to go. Exact to 1 brad."""
    if fade.left < 0:
        for joint in range(JOINTS):
            fade.jump[joint] = saturate(fade.jump[joint] - joints[joint], -65535, 65535)
        fade.left = fade.ticks
    if fade.left > 0:
        for joint in range(JOINTS):
            left = fade.jump[joint] * fade.left // fade.ticks
            joints[joint] = saturate(joints[joint] + left, -32768, 32767)
        fade.left -= 1
    return fade.left
