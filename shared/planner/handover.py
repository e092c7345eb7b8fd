"""Handover between trot and crawl: why, for which commands, and so that no joint goal jumps.

The crawl starts from the measured joints, wherever the feet are; the trot from the goals sent last. A table's first
goals differ from the goals sent last; the difference fades out over half a second.
"""

from ..body.params import JOINTS, Params
from ..num.fixed import saturate
from ..record import field, record, vector
from ..runtime import Ints, const, hot
from .command import Command

# Why the gait was changed
REASON_NONE = const(0)
REASON_HELD = const(1)  # the trot's swings are held up again and again
REASON_COMMAND = const(2)  # the driver commands another gait, or a direction that the crawl cannot go
REASON_EVEN = const(3)  # the ground has been even for a body's length: back to the trot

_STRAIGHT = const(12)  # turning at up to a twelfth of the top speed counts as straight on


@record
class Fade:
    """How far the joint goals still differ from those of the previous mover, fading out."""

    left: int = field("ticks", "still to fade; -1: the jump is not known yet")
    ticks: int = field("ticks", "length of the whole fade")
    jump: Ints = vector(JOINTS, "brad", "goals sent last less the first new ones; at left = -1, the goals sent last")


@hot
def crawl_can_follow(params: Params, command: Command) -> int:
    """Return 1 if the crawl can follow the command: forwards, at most 45 deg sideways, hardly turning; else 0."""
    ahead = command.speed.vx
    aside = command.speed.vy
    turn = saturate(command.speed.wz, -0xFFFFF, 0xFFFFF) * _STRAIGHT
    if ahead <= 0 or aside > ahead or aside < -ahead:
        return 0
    if turn > params.speed_max.wz or turn < -params.speed_max.wz:
        return 0
    return 1


@hot
def fade_start(params: Params, fade: Fade, joints: Ints) -> int:
    """Keep the goals sent last (12 brad), from which the next ones are to go on; return the ticks of the fade."""
    for joint in range(JOINTS):
        fade.jump[joint] = joints[joint]
    fade.left = -1
    fade.ticks = (params.rate_hz >> 1) + 1
    return fade.ticks


@hot
def fade_out(fade: Fade, joints: Ints) -> None:
    """Add what is left of the jump to the goals (12 brad). Exact to 1 brad."""
    if fade.left < 0:
        for joint in range(JOINTS):
            fade.jump[joint] = saturate(fade.jump[joint] - joints[joint], -65535, 65535)
        fade.left = fade.ticks
    if fade.left > 0:
        for joint in range(JOINTS):
            left = fade.jump[joint] * fade.left // fade.ticks
            joints[joint] = saturate(joints[joint] + left, -32768, 32767)
        fade.left -= 1
