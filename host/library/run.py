"""An open robot: its supervisor, its ticks, the values after each, and its record."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..control.arbiter import Client
from ..control.health import Finding, findings
from ..control.loop import Loop
from ..control.messages import Drive, Message
from ..control.opening import open_supervisor
from ..control.supervisor import LEAVING_S
from ..control.telemetry import Extra, about, status
from ..robot.model import Robot
from .errors import Error, Fault, NotAchieved
from .places import Place
from .sensed import Sensed
from .ticks import SimulatedTicks, ThreadTicks

if TYPE_CHECKING:
    from ..records.recorder import Recorder

CLIENT = Client("script")


class Run:
    """From start-up checks to letting go. ``sticks``: the command, sent again in every tick with a waiting caller.

    ``ticks`` may be waited for in whatever state the robot is.
    """

    def __init__(self, robot: Robot, place: Place, record: Path | None) -> None:
        self.robot, self.place = robot, place
        self.sticks: Drive | None = None
        self.sensed = Sensed()
        self._stack = ExitStack()
        self._recorder: Recorder | None = None
        self._log: Callable[[Loop], None] = lambda loop: None
        with ExitStack() as opened:
            self.supervisor = open_supervisor(opened, robot, place.hardware, sleep=place.advance or time.sleep)
            self.rate_hz = self.supervisor.driver.rate_hz
            self.loop = Loop(self.supervisor, self._after_tick, place.clock)
            self._first = status(self.loop, Extra())
            if record is not None:
                self._add_record(opened, record)
            self.ticks: SimulatedTicks | ThreadTicks
            if place.advance is not None:
                self.ticks = SimulatedTicks(self.loop, place.advance)
            else:
                self.ticks = ThreadTicks(self.loop, place.hardware.bus.emergency_stop)
            self.ticks.start()
            self._stack = opened.pop_all()

    def _add_record(self, stack: ExitStack, path: Path) -> None:
        from ..records.log import LoopLog, about
        from ..records.recorder import Recorder, record_path

        recorder = self._recorder = Recorder(record_path(path), about(self.robot, self.supervisor))
        stack.callback(recorder.close)
        log, simulated = LoopLog(recorder), self.place.advance is not None

        def tick(loop: Loop) -> None:
            log.tick(loop)
            if simulated:
                recorder.keep_up()

        self._log = tick

    def _after_tick(self, loop: Loop) -> None:
        supervisor = loop.supervisor
        fault = supervisor.safety.sentence if supervisor.arbiter.stop is None else "emergency stop"
        measured, attitude = supervisor.measured, supervisor.attitude
        rates = self.place.hardware.attitude.rates_rad_s if attitude is not None else None
        swinging = supervisor.driver.planner.status.swinging if supervisor.driver.state == "walking" else 0
        self.sensed = Sensed(
            time_s=loop.clock(),
            state=supervisor.state,
            fault=fault,
            remark=supervisor.remark,
            joints_rad=measured.position_rad,
            speed_rad_s=measured.speed_rad_s,
            goals_rad=tuple(supervisor.goals),
            load=measured.load,
            age_s=measured.age_s,
            attitude_rad=attitude,
            rates_rad_s=rates,
            swinging=tuple(bool(swinging >> leg & 1) for leg in range(4)),
            temperature_C=measured.temperature_C,
            battery_V=measured.battery_V,
            odometry=supervisor.driver.odometry,
        )
        self._log(loop)
        self.ticks.ticked()

    def send(self, message: Message) -> None:
        """Give the loop a message; Error if it refuses."""
        if not self.ticks.do(lambda: self.loop.receive(CLIENT, message)):
            raise Error(f"refused: {self.supervisor.arbiter.refusal}")

    def findings(self) -> tuple[Finding, ...]:
        """Return the verdict on each part, over the time since the robot was opened."""
        extra = Extra()
        extra.look_at(self.place.hardware.attitude)
        last = self.ticks.do(lambda: status(self.loop, extra))
        return tuple(findings(about(self.robot, self.place.hardware), self._first, last))

    def tick(self) -> Sensed:
        """Repeat the command and return the values after the next tick; Fault if the robot has stopped.

        NotAchieved if it was lifted off the ground while it was driven.
        """
        if self.sticks is not None:
            self.send(self.sticks.message())
        self.ticks.wait()
        if self.sensed.fault:
            self.sticks = None
            raise Fault(self.sensed.fault)
        if self.sensed.state == "lifted" and self.sticks is not None and self.sticks.moves:
            self.sticks = None
            raise NotAchieved(self.supervisor.driver.lifted)
        return self.sensed

    @contextmanager
    def driving(self, sticks: Drive | None) -> Iterator[None]:
        """Repeat a command in the ticks of the block, and none after it."""
        self.sticks = sticks
        try:
            yield
        finally:
            self.sticks = None

    def until(self, done: Callable[[Sensed], bool], most_s: float, what: str) -> None:
        """Tick until ``done``; NotAchieved, with the reason, after a time."""
        for _ in range(round(most_s * self.rate_hz)):
            if done(self.sensed):
                return
            self.tick()
        reason = self.supervisor.reason(self.loop.clock())
        raise NotAchieved(f"{what}: not within {most_s:.3g} s: {reason or self.sensed.state}")

    def emergency_stop(self) -> None:
        """Let go at once; may be called from another thread."""
        self.place.hardware.bus.emergency_stop()
        self.ticks.do(lambda: self.loop.receive(CLIENT, {"type": "stop"}))
        self.ticks.wait()

    def close(self) -> None:
        """Sit down, let go, and end everything; let go at once if sitting down is not possible.

        Error at the end if a part of the record is missing: the robot went on without it.
        """
        try:
            self._sit_down()
        except BaseException:
            self.place.hardware.bus.emergency_stop()
            raise
        finally:
            self.ticks.close()
            self._stack.close()
        recorder = self._recorder
        if recorder is not None and recorder.missing:
            raise Error(f"record {recorder.missing}: {recorder.dropped} messages are missing")

    def _sit_down(self) -> None:
        self.ticks.do(self.supervisor.leave)
        for _ in range(round(LEAVING_S * self.rate_hz)):
            if not self.supervisor.armed:
                return
            self.ticks.wait()
        raise NotAchieved(f"the robot did not sit down within {LEAVING_S:g} s, so its joints were let go where it is")
