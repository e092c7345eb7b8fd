"""Position loops on the host: the joint's own cascade from shared/, with the joints in velocity or in current mode.

Each cycle computes one tick of the trajectory per elapsed millisecond, from the last reply, and sends the velocity or
the current that the cascade wants. It acts one cycle later and is held for another: a delay of one and a half cycles,
which a loop in the joint does not have. Therefore

* the position is the one the joint will have when the command acts, at the speed it has;
* the goals' own speed goes into the trajectory, which moves several milliseconds a cycle;
* the gains are lower. POSITION_HZ and VELOCITY_PER_HZ were found by walking in the simulator at 200 and 400 Hz
  (caramelo joints compare): with twice as much the legs swing.
"""

from collections.abc import Mapping, Sequence

from shared.joint.cascade import cascade_reset, follow_position, position_from_wire, rate_from_wire, velocity_loop
from shared.wire import names as w
from shared.wire.codec import Reply

from ...robot.actuators import Drive
from ...robot.joint_gains import JointBlocks
from .link import JointView

MOTION_HZ = 1000
POSITION_HZ = 4.0  # largest bandwidth of the position loop
VELOCITY_PER_HZ = 1 / 20  # largest bandwidth of the velocity loop per rate of the cycle
SETPOINTS = {"host-velocity": w.SETPOINT_VELOCITY_ID, "host-current": w.SETPOINT_CURRENT_ID}
# Kinds of set-point by where the loops are, for busload
KINDS = {"impedance": "impedance", "joint": "position", "host-velocity": "velocity", "host-current": "current"}


class HostLoops:
    """Twelve loops of one kind of ``SETPOINTS``, with the same blocks as the joints."""

    def __init__(self, blocks: Sequence[JointBlocks], drive: Drive, rate_hz: int, kind: str) -> None:
        self._blocks = list(blocks)
        self._rate_hz, self._cycles, self._ticks = rate_hz, 0, 0
        self._current = kind == "host-current"
        self.identifier = SETPOINTS[kind]
        self._started = [False] * len(self._blocks)
        self._wanted = [0] * len(self._blocks)
        position = min(1.0, POSITION_HZ / drive.position_bandwidth_hz)
        velocity = min(1.0, VELOCITY_PER_HZ * rate_hz / drive.velocity_bandwidth_hz)
        for block in self._blocks:
            _slow_down(block, position, velocity, MOTION_HZ / rate_hz)

    def reset(self) -> None:
        """Start again where the joints are, at the next cycle."""
        self._started = [False] * len(self._blocks)

    def setpoints(
        self, goals_brad: Sequence[int], steps_brad: Sequence[float], views: Mapping[int, JointView]
    ) -> list[int]:
        """Return twelve set-points of the wire; NO_CHANGE for a joint without a known position.

        ``steps_brad`` is how far the goals move in a cycle.
        """
        self._ticks = self._milliseconds()
        for i, goal in enumerate(goals_brad):
            reply = views[i + 1].reply
            if reply.position == w.NOT_AVAILABLE:
                self._wanted[i] = w.NO_CHANGE
            else:
                self._wanted[i] = self._setpoint(i, goal, steps_brad[i], reply)
        return self._wanted

    def _milliseconds(self) -> int:
        """Return this cycle's whole milliseconds; if the period is not whole, cycles vary by one."""
        before = self._cycles * MOTION_HZ // self._rate_hz
        self._cycles += 1
        return self._cycles * MOTION_HZ // self._rate_hz - before

    def _setpoint(self, i: int, goal_brad: int, step_brad: float, reply: Reply) -> int:
        block = self._blocks[i]
        state, settings, io = block.state, block.settings, block.io
        rate = rate_from_wire(reply.velocity, settings.rate_q8)
        state.velocity = rate
        state.position = position_from_wire(reply.position, settings.gear_q8)
        if not self._started[i]:
            cascade_reset(settings, state)
            self._started[i] = True
        state.position += rate * MOTION_HZ // (256 * self._rate_hz)
        io.position = goal_brad
        io.velocity = round(step_brad * self._rate_hz / 16)  # brad a cycle to 1/4096 turn/s
        state.sequence = (state.sequence + 1) & 0x3FFFFFFF
        before = state.profile_rate
        for _ in range(self._ticks):
            wanted = follow_position(settings, state, io)
        if not self._current:
            return (wanted >> 2) * settings.wire_rate_q16 >> 14
        change = (state.profile_rate - before) // max(1, self._ticks)
        state.current_reference = change * settings.inertia >> 8
        return velocity_loop(settings, state, 0) * settings.wire_current_q12 >> 12


def _slow_down(block: JointBlocks, position: float, velocity: float, cycle_ms: float) -> None:
    """Lower the gains by shares 0 .. 1; the integral is added up once a cycle."""
    settings, state = block.settings, block.state
    settings.position_p = round(settings.position_p * position)
    settings.velocity_p = round(settings.velocity_p * velocity)
    settings.velocity_i = round(
        settings.velocity_i * velocity * velocity * cycle_ms
    )  # kp w / 4: host/robot/joint_gains.py
    # The joint itself knows its supply and its heat, and limits its set-points.
    state.current_limit = settings.current_max
    state.bus = (settings.under_start + settings.over_start) // 2
