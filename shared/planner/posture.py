"""Slow moves of all twelve joints at once: standing up and sitting down.

They start from the goals sent last, end in a goal pose, and take as long as the joint with the longest way needs at the
robot's slow joint speed. All joints start and arrive together, on a cycloid's profile, so that nothing jerks.
"""

from ..body.params import JOINTS, Params
from ..gait.swing import cycloid_q15
from ..record import field, record, vector
from ..runtime import Ints, hot


@record
class Move:
    """A slow move of all joints from one posture to another."""

    start: Ints = vector(JOINTS, "brad", "where it began")
    goal: Ints = vector(JOINTS, "brad", "where it ends")
    ticks: int = field("ticks", "length of the whole move")
    tick: int = field("ticks", "elapsed")


@hot
def posture_start(params: Params, move: Move, joints: Ints, goal: Ints) -> int:
    """Begin a move from ``joints`` to ``goal`` (12 brad each, within +-32768); return its ticks.

    The peak speed of a cycloid is twice its mean, so it takes twice the ticks of a move at constant speed.
    """
    longest = 0
    for joint in range(JOINTS):
        move.start[joint] = joints[joint]
        move.goal[joint] = goal[joint]
        gap = goal[joint] - joints[joint]
        if gap < 0:
            gap = -gap
        if gap > longest:
            longest = gap
    step = params.joint_speed_slow
    if step < 1:
        step = 1
    move.ticks = 1 + 2 * longest // step
    move.tick = 0
    return move.ticks


@hot
def posture_step(move: Move, joints: Ints) -> int:
    """Write the move's next 12 joint angles into ``joints``; return the ticks still to come.

    Error at most 1.5 brad against the cycloid; the last angles are exactly the goal's. Intermediates: a joint's way is
    below 65536 brad and is taken in halves: 32768 * 32768.
    """
    move.tick += 1
    left = move.ticks - move.tick
    if left <= 0:
        for joint in range(JOINTS):
            joints[joint] = move.goal[joint]
        move.tick = move.ticks
        return 0
    share = cycloid_q15(phase_of(move.tick, move.ticks))
    for joint in range(JOINTS):
        gap = move.goal[joint] - move.start[joint]
        joints[joint] = move.start[joint] + (((gap >> 1) * share + 0x2000) >> 14)
    return left


@hot
def phase_of(tick: int, ticks: int) -> int:
    """Return tick / ticks in Q16 for 0 <= tick <= ticks, ticks 1 .. 2^28. Error at most 4 LSB below 2^20 ticks."""
    while ticks > 16383:
        ticks >>= 1
        tick >>= 1
    return (tick << 16) // ticks
