"""Position loops on the host: the joint's own cascade from shared/, its upper part, with the joints in velocity mode.

Each cycle does as many ticks of trajectory and position loop as milliseconds have passed, on the last reply, and
sends the velocity it wants. The wire adds a cycle of delay that a loop in the joint does not have.
"""

from array import array
from collections.abc import Mapping, Sequence

from shared.joint import layout as j
from shared.joint.cascade import cascade_reset, follow_position, position_from_wire, rate_from_wire
from shared.wire import names as w

from ..joint_gains import JointBlocks
from .link import JointView


class HostLoops:
    """Twelve loops with the blocks that the joints themselves have; ``ticks`` milliseconds a cycle."""

    def __init__(self, blocks: Sequence[JointBlocks], rate_hz: int) -> None:
        self._blocks = list(blocks)
        self._ticks = max(1, round(1000 / rate_hz))
        self._started = [False] * len(self._blocks)
        self._wanted = [0] * len(self._blocks)

    def reset(self) -> None:
        """Start anew where the joints are, at the next cycle."""
        self._started = [False] * len(self._blocks)

    def velocities(self, goals_brad: Sequence[int], views: Mapping[int, JointView]) -> list[int]:
        """Return twelve velocity set-points, 1/4096 turn/s; NO_CHANGE for a joint without a known position."""
        for i, goal in enumerate(goals_brad):
            self._wanted[i] = self._velocity(i, goal, views[i + 1].reply)
        return self._wanted

    def _velocity(self, i: int, goal_brad: int, reply: array) -> int:
        blocks = self._blocks[i]
        state, cfg, io = blocks.state, blocks.cfg, blocks.io
        position = reply[w.REPLY_POSITION]
        if position == w.NOT_AVAILABLE:
            return w.NO_CHANGE
        state[j.S_POSITION] = position_from_wire(position, cfg[j.K_GEAR_Q8])
        state[j.S_VELOCITY] = rate_from_wire(reply[w.REPLY_VELOCITY], cfg[j.K_RATE_Q8])
        if not self._started[i]:
            cascade_reset(cfg, state)
            self._started[i] = True
        io[j.IO_POSITION] = goal_brad
        state[j.S_SEQUENCE] += 1
        for _ in range(self._ticks):
            rate = follow_position(cfg, state, io)
        return (rate >> 2) * cfg[j.K_WIRE_RATE_Q16] >> 14
