"""Before the crawl begins, the held-up trot backs off: it walks back 0.3 of a leg and comes to a stand.

A held-up foot is jammed at an edge, with the trunk leaning on it. A crawl that began there would lift its first foot
while the weight is on the other diagonal, and the robot would tip over; from a level stand clear of the edge it does
not. The way back is the sum of the trot's measured speed.
"""

from ..body.params import LF_BITS, Params
from ..num.fixed import saturate
from ..record import field, record
from ..runtime import const, hot
from .command import Command, copy_command


@record
class Retreat:
    """How far the held-up trot has backed off."""

    moved: int = field("lf", "distance backed off so far")
    ticks: int = field("ticks", "since it began")
    stopping: int = field("", "1: it has backed off far or long enough, and stops")
    stood_ticks: int = field("ticks", "for how long it has stood since")


_LONGEST_S = const(6)  # after this the ground behind is taken to block the robot, and it stops where it is


@hot
def retreat_start(retreat: Retreat) -> None:
    """Begin to back off, from here."""
    retreat.moved = 0
    retreat.ticks = 0
    retreat.stopping = 0
    retreat.stood_ticks = 0


@hot
def retreat_step(
    params: Params, command: Command, moved_lf: int, standing: int, retreat: Retreat, backing: Command
) -> int:
    """Write the trot's command of this tick into ``backing``: backwards, then none; return 1 once it stood for 0.5 s.

    moved_lf: lf, how far the body came forwards in the last tick, limited to +-2^22; standing: 1 if the planner stands.
    The trot goes back by 0.3 of the leg (72 mm for Caramelo) at a tenth of the largest speed; all else is as commanded.
    Intermediates: 3 * 2^15 * 2^8 lf.
    """
    copy_command(command, backing)
    retreat.moved = saturate(retreat.moved - saturate(moved_lf, -0x3FFFFF, 0x3FFFFF), -0xFFFFFFF, 0xFFFFFFF)
    retreat.ticks = saturate(retreat.ticks + 1, 0, 0xFFFF)
    if retreat.moved >= (params.leg_length * 3 << LF_BITS) // 10 or retreat.ticks > params.rate_hz * _LONGEST_S:
        retreat.stopping = 1
    backing.speed.vx = -(params.speed_max.vx // 10)
    backing.speed.vy = 0
    backing.speed.wz = 0
    if retreat.stopping:
        backing.speed.vx = 0
    retreat.stood_ticks = saturate(retreat.stood_ticks + 1, 0, 0xFFFF)
    if retreat.stopping == 0 or standing == 0:
        retreat.stood_ticks = 0
    if retreat.stood_ticks > params.rate_hz >> 1:
        return 1
    return 0
