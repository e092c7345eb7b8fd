"""Before the crawl the held-up trot backs off: it walks back a third of a leg and comes to a stand.

Held up means that a foot is jammed at an edge, the trunk leaning on it. A crawl begun there lifts its first
foot while the robot's weight is across the other diagonal, and it tips over; begun from a level stand clear
of the edge it does not. The way back is measured by the legs' odometry, so slip does not count.
"""

from .command import COMMAND_SIZE, Command
from .fixed import saturate
from .gaits import GAIT_ADAPTIVE
from .params import LF_BITS, Params
from .runtime import Ints, const, hot

# The block begins with the command that the trot is given instead of the driver's, COMMAND_SIZE values
R_MOVED = const(13)  # lf, how far back it has come
R_TICKS = const(14)
R_ENDS = const(15)  # 1: far enough, or for long enough: stop
R_STOOD = const(16)  # ticks in a row that it has stood since
RETREAT_SIZE = const(17)

_LONGEST_S = const(6)  # then the ground behind does not let it back off, and it stops where it is


@hot
def retreat_start(retreat: Ints) -> int:
    """Begin: nothing gone yet; return 0."""
    for at in range(RETREAT_SIZE):
        retreat[at] = 0
    return 0


@hot
def retreat_step(params: Params, command: Ints, moved_lf: int, standing: int, retreat: Command) -> int:
    """Write this tick's command for the trot: backwards, then nothing; return 1 once it has stood for half a second.

    moved: lf, how far the body came forwards in the last tick, limited to +-2^22; standing: 1 if the planner stands.
    Back by 0.3 of the leg (72 mm for Caramelo) at 0.3 of the largest speed, adaptively; all else as commanded.
    Intermediates: 3 * 2^15 * 2^8 lf.
    """
    for at in range(COMMAND_SIZE):
        retreat[at] = command[at]
    retreat[R_MOVED] = saturate(retreat[R_MOVED] - saturate(moved_lf, -0x3FFFFF, 0x3FFFFF), -0xFFFFFFF, 0xFFFFFFF)
    retreat[R_TICKS] = saturate(retreat[R_TICKS] + 1, 0, 0xFFFF)
    if retreat[R_MOVED] >= (params.leg_length * 3 << LF_BITS) // 10 or retreat[R_TICKS] > params.rate_hz * _LONGEST_S:
        retreat[R_ENDS] = 1
    retreat.gait = GAIT_ADAPTIVE
    retreat.speed[0] = -(params.speed_max[0] * 3 // 10)
    retreat.speed[1] = 0
    retreat.speed[2] = 0
    if retreat[R_ENDS]:
        retreat.speed[0] = 0
    retreat[R_STOOD] = saturate(retreat[R_STOOD] + 1, 0, 0xFFFF)
    if retreat[R_ENDS] == 0 or standing == 0:
        retreat[R_STOOD] = 0
    if retreat[R_STOOD] > params.rate_hz >> 1:
        return 1
    return 0
