"""The host's cycle: read what came, check that all is well, send set-points and SYNC, at a fixed rate.

Deadlines are on the monotonic clock and do not drift; how late each cycle starts goes into a histogram. The set-points
interpolate between the planner's goals, so that joints see 200 small steps instead of 50 large ones.

One thread does the cycles. Others may call ``set_goals`` and ``let_go``: both only leave a request for the next cycle,
except that an emergency stop sends its first frame at once. Letting go is repeated until every joint reports no torque.
"""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import tau

from shared.wire import names as w
from shared.wire.codec import Reply

from ...robot.joint_units import Units
from .guard import E_STOP, REACTIONS, Guard, Notice, worst
from .host_loops import HostLoops
from .link import JointLink, JointView

BRAD_PER_RAD = 65536 / tau
_AT_REST = (0.0,) * 12
TORQUE_STATES = (w.STATE_OPERATION_ENABLED, w.STATE_QUICK_STOP_ACTIVE, w.STATE_FAULT_REACTION)
GAINS_AGAIN = 40  # cycles after which a spring's gains are sent again: a joint that came back has none
DISARM_AGAIN = 4  # cycles between two tries: a joint answers within a millisecond, by a heartbeat
JITTER_EDGES_S = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02)


@dataclass
class Timing:
    """How late cycles started, and how many were skipped because the host was away."""

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
    """Sends ``rate_hz`` times a second. ``goals`` are motor angles, brad; None: send only SYNC.

    ``spring``: stiffness and damping with which the joints hold their goals; None: they hold them by their cascade.
    """

    def __init__(
        self,
        link: JointLink,
        rate_hz: int,
        units: Units,
        loops: HostLoops | None,
        report: Callable[[Notice], None] | None,
        spring: tuple[int, int] | None,
    ) -> None:
        self.link, self.period_s, self.loops, self._spring = link, 1 / rate_hz, loops, spring
        self._kind = w.SETPOINT_IMPEDANCE_ID if spring else w.SETPOINT_POSITION_ID
        self.guard = Guard(link, units)
        self.timing = Timing()
        self.armed = False
        self.reaction = "none"
        self.notices: list[Notice] = []
        self._report = report
        self.letting_go = ""  # "disarm" or "stop" until all joints have said that they are off
        self._goals: list[float] | None = None
        self._wanted: tuple[list[float], float] | None = None
        self._let_go_s = 0.0
        self._repeats = self._e_stops = 0
        self._word = threading.Lock()  # over letting_go, armed and the goals; nothing is sent while it is held
        self._holding = False
        self._steps = [0.0] * 12
        self._left = 0
        self.due_s = link.port.now()

    @property
    def goals_brad(self) -> list[float] | None:
        """Return the motor angles of the last set-points; None while there are none."""
        goals = self._goals  # another thread may end them
        return None if goals is None else list(goals)

    def hold(self) -> None:
        """Set the goals to where the joints are, each until it is enabled: they are armed with these goals."""
        self._holding = True
        self._goals = [float(_position(self.link.views[node].reply)) for node in self.link.nodes]
        self._left = 0
        if self.loops is not None:
            self.loops.reset()

    def set_goals(self, goals_rad: Sequence[float], within_s: float = 0.0) -> None:
        """Go to twelve motor angles at constant speed within a time, from the next cycle on."""
        self._wanted = ([angle * BRAD_PER_RAD for angle in goals_rad], within_s)

    def _take_wanted(self) -> None:
        with self._word:  # a stop of another thread ends goals and arming together
            wanted, self._wanted = self._wanted, None
            if wanted is None or not self.armed:
                return
            goals, within_s = wanted
            at = self._goals = list(goals) if self._goals is None else self._goals
        self._left = max(1, round(within_s / self.period_s))
        self._steps = [(to - now) / self._left for to, now in zip(goals, at, strict=True)]

    def run_until(self, time_s: float) -> None:
        """Do the cycles due until a time, each at its own time; skip those whose time is over."""
        port = self.link.port
        while self.due_s <= time_s:
            port.wait_until(self.due_s)
            late_s = port.now() - self.due_s
            self.timing.note(max(0.0, late_s))
            self.step()
            self.due_s += self.period_s
            behind = int((port.now() - self.due_s) / self.period_s)
            if behind > 0:
                self.timing.skipped += behind
                self.due_s += behind * self.period_s
        port.wait_until(time_s)
        self.link.receive()

    def step(self) -> None:
        """Do one cycle now."""
        self.link.receive()
        if self.letting_go:
            self._let_go_again()
        if self.armed:
            self._watch()
        self._take_wanted()
        goals = self._goals  # another thread may end them
        if goals is not None:
            if self._holding:
                self._follow(goals)
            self._send_goals(goals)
        self.link.sync()

    def _send_goals(self, goals: list[float]) -> None:
        moving = self._left > 0
        if moving:
            self._left -= 1
            for i, step in enumerate(self._steps):
                goals[i] += step
        brads = [round(goal) for goal in goals]
        if self._spring is not None and (self._holding or self.link.syncs % GAINS_AGAIN == 0):
            self.link.send_setpoints(w.IMPEDANCE_STIFFNESS_ID, [self._spring[0]] * 12)
            self.link.send_setpoints(w.IMPEDANCE_DAMPING_ID, [self._spring[1]] * 12)
        if self.loops is None:
            self.link.send_setpoints(self._kind, brads)
        else:
            steps = self._steps if moving else _AT_REST
            self.link.send_setpoints(self.loops.identifier, self.loops.setpoints(brads, steps, self.link.views))

    def _watch(self) -> None:
        """Check the joints; report a reaction that is stronger than the previous one, and carry it out."""
        notices = self.guard.while_armed()
        if self.link.e_stops != self._e_stops:
            notices = [Notice(0, "e-stop", E_STOP, "stop")]
        reaction = worst(notices)
        if REACTIONS.index(reaction) <= REACTIONS.index(self.reaction):
            return
        self.reaction, self.notices = reaction, [notice for notice in notices if notice.reaction == reaction]
        if self._report is not None:
            for notice in self.notices:
                self._report(notice)
        if reaction == "damp":
            self.damp()
        elif reaction == "stop":
            self.stop()

    def _follow(self, goals: list[float]) -> None:
        for i, node in enumerate(self.link.nodes):
            view = self.link.views[node]
            if not view.enabled:
                goals[i] = float(_position(view.reply))

    def start(self) -> bool:
        """Watch the joints from now on: they are armed. False if they must let go instead."""
        self._holding = False
        self.reaction, self.notices, self._e_stops = "none", [], self.link.e_stops
        self.guard.start()
        with self._word:
            self.armed = not self.letting_go
            return self.armed

    def end(self) -> None:
        """End the set-points and the watching."""
        self.armed = self._holding = False
        self._goals = self._wanted = None

    def damp(self) -> None:
        """Quick-stop all joints, and send no more set-points."""
        self.end()
        for node in self.link.nodes:
            self.link.request(node, w.COMMAND_QUICK_STOP)

    def let_go(self, how: str) -> None:
        """Take all torque away: ``disarm``, from the next cycle on; ``stop``, at once and before all other frames.

        Repeated until all joints have confirmed that they are off. A stop replaces disarming, but not the other way
        round.
        """
        with self._word:
            self.end()
            self._let_go_s, self._repeats = self.link.port.now(), 0
            if self.letting_go != "stop":
                self.letting_go = how
        if how == "stop":
            self.link.emergency_stop()

    def stop(self) -> None:
        """Take all torque away, even from a joint that does not hear its own emergency stop."""
        self.let_go("stop")

    @property
    def holding(self) -> list[int]:
        """The nodes that have not confirmed that they are off since they were told to let go."""
        views, since_s = self.link.views, self._let_go_s
        return [node for node in self.link.nodes if not _is_off(views[node], since_s)]

    def _let_go_again(self) -> None:
        since_s, holding = self._let_go_s, self.holding
        if not holding:
            with self._word:
                if since_s == self._let_go_s:
                    self.letting_go = ""
        elif self.letting_go == "stop":
            self.link.emergency_stop()
        elif self._repeats % DISARM_AGAIN == 0:
            for node in holding:
                self.link.request(node, w.COMMAND_DISARM)
        self._repeats += 1


def _is_off(view: JointView, since_s: float) -> bool:
    return view.heartbeat_s > since_s and view.state not in TORQUE_STATES


def _position(reply: Reply) -> int:
    return 0 if reply.position == w.NOT_AVAILABLE else reply.position
