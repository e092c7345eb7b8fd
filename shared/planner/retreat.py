"""Before the crawl the held-up trot backs off: it walks back a third of a leg and comes to a stand.

Held up means that a foot is jammed at an edge, the trunk leaning on it. A crawl begun there lifts its first
foot while the robot's weight is across the other diagonal, and it tips over; begun from a level stand clear
of the edge it does not. The way back is measured by the legs' odometry, so slip does not count.
"""

from ..body.params import LF_BITS, Params
from ..num.fixed import saturate
from ..record import field, record
from ..runtime import const, hot
from .command import Command, repeat_command


@record
class Retreat:
    """How far the held-up trot has backed off."""

    moved: int = field("lf", "how far back it has come")
    ticks: int = field("ticks", "since it began")
    ends: int = field("", "1: far enough, or for long enough: stop")
    stood: int = field("ticks", "in a row that it has stood since")


_LONGEST_S = const(6)  # then the ground behind does not let it back off, and it stops where it is


@hot
def retreat_start(retreat: Retreat) -> None:
    """Begin: nothing gone yet."""
    retreat.moved = 0
    retreat.ticks = 0
    retreat.ends = 0
    retreat.stood = 0


@hot
def retreat_step(
    params: Params, command: Command, moved_lf: int, standing: int, retreat: Retreat, told: Command
) -> int:
    """Write this tick's command for the trot into ``told``: backwards, then nothing.

    Returns 1 once it has stood for half a second.

    moved: lf, how far the body came forwards in the last tick, limited to +-2^22; standing: 1 if the planner stands.
    Back by 0.3 of the leg (72 mm for Caramelo) at a tenth of the largest speed; all else as commanded.
    Intermediates: 3 * 2^15 * 2^8 lf.
    """
    repeat_command(command, told)
    retreat.moved = saturate(retreat.moved - saturate(moved_lf, -0x3FFFFF, 0x3FFFFF), -0xFFFFFFF, 0xFFFFFFF)
    retreat.ticks = saturate(retreat.ticks + 1, 0, 0xFFFF)
    if retreat.moved >= (params.leg_length * 3 << LF_BITS) // 10 or retreat.ticks > params.rate_hz * _LONGEST_S:
        retreat.ends = 1
    told.speed.vx = -(params.speed_max.vx // 10)
    told.speed.vy = 0
    told.speed.wz = 0
    if retreat.ends:
        told.speed.vx = 0
    retreat.stood = saturate(retreat.stood + 1, 0, 0xFFFF)
    if retreat.ends == 0 or standing == 0:
        retreat.stood = 0
    if retreat.stood > params.rate_hz >> 1:
        return 1
    return 0
