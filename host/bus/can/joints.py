"""The robot of twelve brushless joints on CAN behind the one interface to a robot's joints.

The cycle (host/bus/can/cycle.py) turns the planner's 50 goals a second into 200 set-points. With ``threaded`` it runs
in a thread of its own, as on the robot, and only that thread uses the bus: the caller reads what the thread has heard,
leaves goals, and requests what takes several exchanges (arming, clearing); the thread does that between its cycles.
Nobody waits for it. Only an emergency stop is sent by the caller's own thread. Without ``threaded`` the caller calls
``run_until``, as in simulated time, and every request is done at once.
"""

import queue
import secrets
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from math import inf, tau

from shared.wire import names as w
from shared.wire.codec import SlowStatus
from shared.wire.parameters import PARAMETER_CURRENT_MAX

from ...robot.coupling import to_joint, to_motor
from ...robot.joint_gains import impedance_gains, joint_blocks
from ...robot.joint_setups import joint_setups
from ...robot.model import Robot
from ...util.errors import NOT_ACHIEVED, UserError
from ..base import JOINTS, Bus, Fault, Measured, checked_fraction, checked_goals
from .cycle import TORQUE_STATES, Cycle
from .guard import Notice
from .host_loops import HostLoops
from .link import JointLink
from .port import Port
from .service import Requests, joint_name

LISTEN_S = 0.45  # two heartbeats of every joint
LISTEN_MOST_S = 1.5
APPROACH_S = 0.03  # set-points before arming: the joints need fresh ones
ENABLE_S = 0.05
POLL_S = 0.001
ABANDONED_S = 0.2  # a caller that has not repeated its request for torque for this long no longer wants it
OFF_S = 0.3  # until all joints have confirmed that they are off: a heartbeat and some
DISARM_S = 0.1  # then joints that have not confirmed it get an emergency stop
JOIN_S = 1.0
ACTIONS = {"sit": "sit", "damp": "damp", "stop": "limp"}  # of control/safety.py, by reaction of guard.py
OVERTAKEN = "an emergency stop came first"
HOME_POSE = 1  # index of a home request: the joint stands at the value

_RAD_PER_BRAD = tau / 65536
_RAD_S_PER_WIRE = tau / 4096


class CanJoints(Bus):
    """``pose_rad`` is the robot's sitting pose when it is switched on: joints without an encoder home there."""

    kind = "can"

    def __init__(
        self,
        robot: Robot,
        port: Port,
        session: int,
        pose_rad: Sequence[float] | None,
        threaded: bool = False,
        report: Callable[[Notice], None] | None = None,
    ) -> None:
        super().__init__()
        if robot.bus.kind != "can" or robot.actuator.kind != "bldc":
            raise UserError(f"{robot.name} has no joints on CAN")
        self.robot, self.port, self._pose = robot, port, pose_rad
        self._blocks = [joint_blocks(robot.actuator, setup) for setup in joint_setups(robot)]
        self.link = JointLink(port, session)
        spring = impedance_gains(robot.actuator) if robot.bus.loops == "impedance" else None
        self.cycle = Cycle(self.link, robot.bus.rate_hz, self._blocks[0].units, _host_loops(robot), report, spring)
        self.requests = Requests(self.link, self.cycle.run_until)
        self._tick_s = 1 / robot.control.rate_hz
        self._fraction = 1.0
        self._threaded, self._over = threaded, threading.Event()
        self._thread: threading.Thread | None = None
        self._failure: Exception | None = None
        self._waiting: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._stops = 0  # emergency stops so far
        self._stops_before: int | None = None  # the work that is being done was asked for
        self._tried: dict[Callable[[], None], Future[None]] = {}  # what a loop asks for again in every tick
        self._tried_s = 0.0  # when it last asked for torque

    def open(self) -> None:
        """See Bus: listen, look for boards, refuse joints that must not be armed, home joints without an encoder."""
        try:
            self.listen()
            self.make_ready()
        except BaseException:
            self.port.close()
            raise
        if self._threaded:
            self._thread = threading.Thread(target=self._run, name="can-cycle", daemon=True)
            self._thread.start()

    def make_ready(self) -> None:
        """Look for boards, refuse with UserError joints that must not be armed, home joints without an encoder."""
        self.refuse_unfit(self.requests.discover())
        self._home()

    def refuse_unfit(self, boards: dict[int, set[int]] | None = None) -> None:
        """Refuse with UserError joints that must not be armed; ``boards`` as discovered."""
        wrong = self.cycle.guard.before_arming(boards)
        if wrong:
            raise UserError("; ".join(notice.sentence for notice in wrong), NOT_ACHIEVED)

    def listen(self) -> None:
        """Wait for two heartbeats of every joint, and longer for those that are late."""
        end_s = self.now() + LISTEN_MOST_S
        self.run_for(LISTEN_S)
        while any(self.link.views[node].heartbeat_s == -inf for node in self.link.nodes) and self.now() < end_s:
            self.run_for(2 * self.cycle.period_s)

    def _home(self) -> None:
        lost = [n for n in self.link.nodes if self.link.views[n].reply.position == w.NOT_AVAILABLE]
        if lost and self._pose is None:
            raise UserError(f"{joint_name(lost[0])} does not know its angle: put the robot into its sitting pose")
        motors = to_motor(self.robot, self._pose) if self._pose is not None else []
        for node in lost:
            pose = round(motors[node - 1] / _RAD_PER_BRAD)
            self.requests.challenged(node, w.COMMAND_HOME, HOME_POSE, low=pose)
        self.run_for(2 * self.cycle.period_s)

    def _run(self) -> None:
        """Do the cycles at their times, and the requested work between them."""
        try:
            while not self._over.is_set():
                due_s = self.cycle.due_s
                self.port.wait_until(due_s)
                self.cycle.run_until(max(due_s, self.port.now()))
                if not self._waiting.empty():
                    self._waiting.get_nowait()()
        except Exception as error:
            self._failure = error  # without set-points the joints damp; the caller learns of it at once

    def _do(self, work: Callable[[], None], stops: int, result: "Future[None]") -> None:
        """Do some work and keep how it ended; an emergency stop after ``stops`` of them ends it."""
        self._stops_before = stops
        try:
            work()
        except Exception as error:
            result.set_exception(error)
        else:
            result.set_result(None)
        self._stops_before = None

    def _soon(self, work: Callable[[], None]) -> "Future[None]":
        """Let the cycle's thread do something; without a thread do it now."""
        result: Future[None] = Future()
        do = partial(self._do, work, self._stops, result)
        if self._thread is None:
            do()
        else:
            self._waiting.put(do)
        return result

    def _settle(self, asked: "Future[None]") -> None:
        """Wait until it is done; raises what went wrong. For commands, not for a loop."""
        while not asked.done():
            self._check_thread()
            time.sleep(POLL_S)
        asked.result()

    def _still_wanted(self) -> Requests:
        """Return the requests to use during some work; UserError if an emergency stop came meanwhile."""
        if self._stops_before not in (None, self._stops):
            raise UserError(OVERTAKEN, NOT_ACHIEVED)
        return self.requests

    def await_off(self) -> None:
        """Wait until all joints have confirmed that they let go; UserError names those that have not."""
        end_s = self.now() + OFF_S
        while self.cycle.letting_go and self.now() < end_s:
            self.cycle.run_until(self.now() + self.cycle.period_s)
        if self.cycle.letting_go:
            names = ", ".join(joint_name(node) for node in self.cycle.holding)
            raise UserError(f"not confirmed to have let go: {names}: check power and the CAN cable", NOT_ACHIEVED)

    def run_for(self, seconds: float) -> None:
        """Go on with the cycle for a time."""
        self.run_until(self.port.now() + seconds)

    def run_until(self, time_s: float) -> None:
        """Go on with the cycle until a time of ``now``."""
        if self._thread is None:
            self.cycle.run_until(time_s)
            return
        while self.port.now() < time_s:
            self._check_thread()
            time.sleep(POLL_S)

    def _check_thread(self) -> None:
        if self._failure is not None:
            raise UserError(f"the cycle on {self.port.name} has ended: {self._failure}", NOT_ACHIEVED)

    @property
    def firmware(self) -> str:
        """See Bus."""
        views = (self.link.views[node] for node in self.link.nodes)
        builds = {view.heartbeat.build for view in views if view.heartbeat_s > -inf}
        return ", ".join(f"build {build:06x}" for build in sorted(builds))

    def now(self) -> float:
        """See Bus."""
        return self.port.now()

    def read(self) -> Measured:
        """See Bus: what the cycle has heard."""
        self._check_thread()
        arming = self._tried.get(self._arm)
        if arming is not None and arming.done() and self.now() - self._tried_s > ABANDONED_S:
            self._tried.pop(self._arm, None)
            self.torque(False)
        if self._thread is None:
            self.link.receive()
        return self._measured()

    def _measured(self) -> Measured:
        now, views = self.now(), [self.link.views[node] for node in self.link.nodes]
        self._count()
        position = [_known(view.reply.position) * _RAD_PER_BRAD for view in views]
        speed = [_known(view.reply.velocity) * _RAD_S_PER_WIRE for view in views]
        drive = self.robot.actuator
        assert drive.kind == "bldc"
        amperes = drive.drive.current_limit_A
        return Measured(
            time_s=now,
            position_rad=tuple(to_joint(self.robot, position)),
            speed_rad_s=tuple(to_joint(self.robot, speed)),
            load=tuple(max(-1.0, min(1.0, _known(v.reply.current) / 4096 / amperes)) for v in views),
            temperature_C=tuple(_warmest_C(v.status) for v in views),
            voltage_V=tuple(v.status.bus_voltage / 16 for v in views),
            error=tuple(self.cycle.guard.fault_text(v) if v.heartbeat.fault else "" for v in views),
            age_s=tuple(now - v.reply_s if v.reply_s > -inf else inf for v in views),
            slow_age_s=tuple(now - v.status_s if v.status_s > -inf else inf for v in views),
            faults=tuple(Fault(ACTIONS[n.reaction], n.what, n.sentence) for n in self.cycle.notices),
        )

    def _count(self) -> None:
        counters, views = self.counters, self.link.views
        counters.sent = self.link.syncs * JOINTS
        counters.answered = sum(views[node].replies for node in self.link.nodes)
        counters.per_joint_lost = [views[node].lost for node in self.link.nodes]
        counters.lost = sum(counters.per_joint_lost)
        counters.corrupted = sum(views[node].bad for node in self.link.nodes)

    def write(self, goals_rad: Sequence[float]) -> None:
        """See Bus; nothing is sent while the joints are not armed."""
        motors = to_motor(self.robot, checked_goals(goals_rad))
        if self.cycle.armed:
            self.cycle.set_goals(motors, self._tick_s)

    def torque(self, on: bool) -> None:
        """See Bus: arm all joints where they are, or none; or disarm all, from the next cycle on."""
        if on:
            self._settle(self._soon(self._arm))
        else:
            self.cycle.let_go("disarm")
            if self._thread is None:
                self._run_until_off(OFF_S)

    def _arm(self) -> None:
        self.refuse_unfit()
        self.await_off()
        self._write_current_limits()
        views = self.link.views
        self.cycle.hold()
        self.cycle.run_until(self.now() + APPROACH_S)
        try:
            for node in self.link.nodes:
                self._still_wanted().challenged(node)
            self.cycle.run_until(self.now() + ENABLE_S)
            for node in self.link.nodes:
                if not views[node].enabled:
                    why = self.cycle.guard.fault_text(views[node])
                    raise UserError(f"{joint_name(node)} accepted arming but is not armed: {why}", NOT_ACHIEVED)
            if not self.cycle.start():
                raise UserError(OVERTAKEN, NOT_ACHIEVED)
        except UserError:
            self.cycle.let_go("disarm")
            raise

    def _write_current_limits(self) -> None:
        for node, block in zip(self.link.nodes, self._blocks, strict=True):
            limit = round(block.settings.current_max * self._fraction)
            self._still_wanted().demand(node, w.COMMAND_WRITE_PARAMETER, PARAMETER_CURRENT_MAX, limit)

    def limit_torque(self, fraction: float) -> None:
        """See Bus; a joint takes a new current limit only while it is disarmed, so it applies from the next arming."""
        self._fraction = checked_fraction(fraction)

    def try_torque(self) -> bool:
        """See Bus. Torque that the caller no longer waits for is taken away again."""
        self._tried_s = self.now()
        return self._try(self._arm)

    def clear_faults(self) -> None:
        """Clear the joints' latched faults; arming is another step. UserError if a cause is still there."""
        self._settle(self._soon(self._clear))

    def try_clear_faults(self) -> bool:
        """See Bus."""
        return self._try(self._clear)

    def _try(self, work: Callable[[], None]) -> bool:
        """Return whether work is done that was asked for now or before; raises what went wrong."""
        asked = self._tried.get(work)  # another thread's stop may forget it
        if asked is None:
            asked = self._tried[work] = self._soon(work)
        if not asked.done():
            return False
        self._tried.pop(work, None)
        asked.result()
        return True

    def _clear(self) -> None:
        """Clear the joints that have a fault, once all have heard that they must let go."""
        self.await_off()
        self.cycle.notices = []
        for node in self.link.nodes:
            if self.link.views[node].state == w.STATE_FAULT:
                self._still_wanted().demand(node, w.COMMAND_CLEAR_FAULT)
        self.cycle.run_until(self.now() + ENABLE_S)

    def emergency_stop(self) -> None:
        """See Bus: one frame to all, before any other, repeated until all joints have confirmed that they are off."""
        self._stops += 1
        self._tried.clear()
        self.cycle.stop()

    def close(self) -> None:
        """See Bus; takes a bounded time even if nobody answers."""
        if self.link.syncs and not self._over.is_set():
            self._let_all_go()
        self._over.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join(JOIN_S)
        self.port.close()

    def _let_all_go(self) -> None:
        self._stops += 1
        if self._failure is None:
            self.cycle.let_go("disarm")
            self._run_until_off(DISARM_S)
        holding = [node for node in self.cycle.holding if self.link.views[node].state in TORQUE_STATES]
        if self._failure is not None or (self.cycle.letting_go and holding):
            self.cycle.stop()
            self._run_until_off(OFF_S)

    def _run_until_off(self, within_s: float) -> None:
        end_s = self.now() + within_s
        while self.cycle.letting_go and self._failure is None and self.now() < end_s:
            self.run_for(self.cycle.period_s)


def new_session() -> int:
    """Return a session 1 .. 255 that is most likely new to the joints."""
    return 1 + secrets.randbelow(255)


def _host_loops(robot: Robot) -> HostLoops | None:
    """Return the position loops of a robot whose file wants them on the host."""
    bus, actuator = robot.bus, robot.actuator
    assert bus.kind == "can"
    assert actuator.kind == "bldc"
    if bus.loops in ("impedance", "joint"):
        return None
    blocks = [joint_blocks(actuator, setup) for setup in joint_setups(robot)]
    return HostLoops(blocks, actuator.drive, bus.rate_hz, bus.loops)


def _known(raw: int) -> int:
    return 0 if raw == w.NOT_AVAILABLE else raw


def _warmest_C(status: SlowStatus) -> float:
    measured = (status.winding_temperature, status.mcu_temperature)
    return max((raw for raw in measured if raw != w.NOT_AVAILABLE_13), default=0) / 16
