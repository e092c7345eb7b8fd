"""The host's cycle: read what came, look whether all is well, send set-points and SYNC, at a fixed rate.

Deadlines are on the monotonic clock and do not drift; how late each cycle starts goes into a histogram. Between the
planner's goals the set-points go straight from one to the next, so that joints see 200 small steps and not 50 large.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import tau

from shared.wire import names as w

from ..joint_gains import Units
from .guard import Guard, Notice, worst
from .host_loops import HostLoops
from .link import JointLink

BRAD_PER_RAD = 65536 / tau
JITTER_EDGES_S = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02)


@dataclass
class Timing:
    """How late cycles started, and how many were left out because the host was away."""

    late: list[int] = field(default_factory=lambda: [0] * (len(JITTER_EDGES_S) + 1))
    worst_s: float = 0.0
    skipped: int = 0

    def note(self, late_s: float) -> None:
        """Count one cycle."""
        place = sum(late_s >= edge for edge in JITTER_EDGES_S)
        self.late[place] += 1
        self.worst_s = max(self.worst_s, late_s)

    def as_dict(self) -> dict[str, object]:
        """Return the histogram by upper edge."""
        edges = [f"< {1000 * edge:g} ms" for edge in JITTER_EDGES_S] + [f">= {1000 * JITTER_EDGES_S[-1]:g} ms"]
        return {
            "late": dict(zip(edges, self.late, strict=True)),
            "worst_ms": round(1000 * self.worst_s, 3),
            "skipped": self.skipped,
        }


class Cycle:
    """Sends ``rate_hz`` times a second. ``goals`` are motor angles, brad; None sends SYNC alone."""

    def __init__(
        self,
        link: JointLink,
        rate_hz: int,
        units: Units | None = None,
        loops: HostLoops | None = None,
        report: Callable[[Notice], None] | None = None,
    ) -> None:
        self.link, self.period_s, self.loops = link, 1 / rate_hz, loops
        self.guard = Guard(link, units)
        self.timing = Timing()
        self.armed = False
        self.reaction = "none"
        self.notices: list[Notice] = []
        self._report = report
        self._goals: list[float] | None = None
        self._steps = [0.0] * 12
        self._left = 0
        self._due_s = link.port.now()

    def hold(self) -> None:
        """Have the goals be where the joints are now: what they are armed with."""
        self._goals = [float(_position(self.link.views[node].reply)) for node in self.link.nodes]
        self._left = 0
        if self.loops is not None:
            self.loops.reset()

    def set_goals(self, goals_rad: Sequence[float] | None, within_s: float = 0.0) -> None:
        """Go to twelve motor angles, evenly within a time; None ends the set-points."""
        if goals_rad is None:
            self._goals = None
            return
        wanted = [angle * BRAD_PER_RAD for angle in goals_rad]
        if self._goals is None:
            self._goals = list(wanted)
        self._left = max(1, round(within_s / self.period_s))
        self._steps = [(to - at) / self._left for to, at in zip(wanted, self._goals, strict=True)]

    def run_until(self, time_s: float) -> None:
        """Do the cycles due until a time, each at its own; leave out those that are over already."""
        port = self.link.port
        while self._due_s <= time_s:
            port.wait_until(self._due_s)
            late_s = port.now() - self._due_s
            self.timing.note(max(0.0, late_s))
            self.step()
            self._due_s += self.period_s
            behind = int((port.now() - self._due_s) / self.period_s)
            if behind > 0:
                self.timing.skipped += behind
                self._due_s += behind * self.period_s
        port.wait_until(time_s)
        self.link.receive()

    def step(self) -> None:
        """Do one cycle now."""
        self.link.receive()
        if self.armed:
            self._watch()
        if self._goals is not None:
            self._send_goals(self._goals)
        self.link.sync()

    def _send_goals(self, goals: list[float]) -> None:
        if self._left > 0:
            self._left -= 1
            for i, step in enumerate(self._steps):
                goals[i] += step
        brads = [round(goal) for goal in goals]
        if self.loops is None:
            self.link.send_setpoints(w.SETPOINT_POSITION_ID, brads)
        else:
            self.link.send_setpoints(w.SETPOINT_VELOCITY_ID, self.loops.velocities(brads, self.link.views))

    def _watch(self) -> None:
        self.notices = self.guard.while_armed()
        reaction = worst(self.notices)
        if reaction in ("none", self.reaction):
            return
        if self.reaction != "damp":
            self.reaction = reaction
        if self._report is not None:
            for notice in self.notices:
                self._report(notice)
        if reaction == "damp":
            self.damp()

    def damp(self) -> None:
        """Quick stop of all joints, and no set-point any more."""
        self.armed = False
        self._goals = None
        for node in self.link.nodes:
            self.link.request(node, w.COMMAND_QUICK_STOP)


def _position(reply: Sequence[int]) -> int:
    return 0 if reply[w.REPLY_POSITION] == w.NOT_AVAILABLE else reply[w.REPLY_POSITION]
