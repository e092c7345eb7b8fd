"""One drive from start-up checks to sitting down: assembles bus, sources, page, record and loop, and ends them.

At the end the joints are let go before anything else. Record, page and screen only listen: they end after that, each
by itself and within a time limit, and one that hangs is left behind.
"""

import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..control import priority
from ..control.arbiter import Client
from ..control.hardware import Hardware
from ..control.loop import Loop
from ..control.messages import Message
from ..control.opening import open_supervisor
from ..control.supervisor import LEAVING_S, Supervisor
from ..control.telemetry import Extra, StartCheck, about, status
from ..robot.file import find
from ..robot.model import Robot
from ..util.console import write_error
from ..util.errors import UserError
from .ending import end_all
from .gamepad import Gamepad, open_gamepad
from .hub import Hub
from .keyboard import Keyboard
from .leaving import Leaving
from .measure import Measure, cpu_seconds
from .qr import page_address, qr_lines, shows_blocks
from .side import FOXGLOVE, PAGE, SideProcess, listen_address
from .terminal import Screen, raw_keys

STATUS_HZ = 20
GAMEPAD_HZ = 20
END_S = 6.0  # for record, page and screen together; a record on a slow disk takes a while


@dataclass(frozen=True)
class Options:
    """The options of the command line."""

    robot: str
    web: bool
    listen: str
    foxglove: bool
    foxglove_port: int
    log: Path | None
    keep_GB: float | None
    socket: str | None
    gamepad: str | None
    measure_s: float | None
    terminal: bool


class Session:
    """A drive of a robot with ``hardware``, which is opened when the drive begins.

    ``say`` prints a line of the start-up; ``free`` is called at the end, once the joints are let go.
    """

    def __init__(
        self,
        options: Options,
        robot: Robot,
        hardware: AbstractContextManager[Hardware],
        say: Callable[[str], None],
        free: Callable[[], object],
    ) -> None:
        self.options, self.robot, self._hardware, self._say, self._free = options, robot, hardware, say, free
        self.extra = Extra()
        self._leave_s = 0.0
        self._leaving: Leaving | None = None
        self._closers: dict[str, Callable[[], object]] = {}  # of the listeners, by name
        self._after: list[Callable[[Loop], None]] = []
        self._screen: Screen | None = None
        self._web: SideProcess | None = None
        self._foxglove: SideProcess | None = None
        self._qr: list[str] = []
        self._invitation = ""  # only for the terminal, because it contains the pairing code
        self._measure: Measure | None = None

    def run(self) -> dict[str, Any]:
        """Start, drive until told to leave, sit down; return the figures. UserError if a check fails."""
        with ExitStack() as stack:
            # Before the emulated servos start, so that they inherit it: they stand for hardware.
            self._note(StartCheck("priority", True, priority.ask()))
            self._parts = parts = stack.enter_context(self._hardware)
            self.extra.ground = "" if parts.stage is None else next(iter(parts.stage.grounds))
            supervisor = open_supervisor(stack, self.robot, parts, self._note)
            loop = Loop(supervisor, self._after_tick)
            hub = Hub(self._gate(loop), loop.drop)
            hub.about = about(self.robot, parts)
            try:
                self._drive(stack, hub, loop)
            finally:
                try:
                    parts.bus.close()
                finally:
                    self._free()
                    hub.close()  # the servers' processes end with their connection
                    left = end_all(self._closers, END_S)
            return {**self._figures(loop), "left_behind": left}

    def _drive(self, stack: ExitStack, hub: Hub, loop: Loop) -> None:
        """Add the sources and the listeners, and run."""
        self._add_sources(stack, hub, loop)
        self._add_log(loop.supervisor)
        self._leaving = stack.enter_context(Leaving(loop.end))
        hub.add_input(self._leaving)
        self._say("ready")
        self._add_screen()
        loop.run(hub)

    def _note(self, check: StartCheck) -> None:
        self.extra.checks.append(check)
        self._say(f"{'ok' if check.ok else 'FAIL':5} {check.name}: {check.result}")

    def _add_sources(self, stack: ExitStack, hub: Hub, loop: Loop) -> None:
        options, rate_hz = self.options, loop.supervisor.driver.rate_hz
        if options.socket is not None:
            hub.listen(options.socket)
            self._note(StartCheck("socket", True, options.socket))
        if options.gamepad is not None:
            pad = open_gamepad(self.robot, loop.supervisor.fastest, options.gamepad)
            hub.add_input(pad)
            self._after.append(_every(rate_hz // GAMEPAD_HZ, lambda loop: _repeat(loop, pad)))
            self._note(StartCheck("gamepad", True, "found; hold the left shoulder button to drive"))
        if options.web or options.foxglove:
            self._add_servers(hub, loop)
        if options.measure_s is not None:
            self._measure = Measure(options.measure_s, self.robot.speed_limits.vx_m_s, self._page_cpu_s)
            self._after.append(self._measure.tick)
        if options.terminal:
            stack.enter_context(raw_keys(sys.stdin.fileno()))
            hub.add_input(Keyboard(self.robot, loop.supervisor.fastest, sys.stdin.fileno()))
        self._after.append(_every(rate_hz // STATUS_HZ, lambda loop: self._publish(loop, hub)))

    def _add_servers(self, hub: Hub, loop: Loop) -> None:
        """Serve the page and Foxglove's viewers, with the same pairing code."""
        from .web.access import is_loopback, new_code
        from .web.paired import paired_path

        options, (address, port) = self.options, listen_address(self.options.listen)
        code = new_code()
        setup = {"robot": str(find(options.robot)), "code": code, "about": hub.about, "paired": str(paired_path())}
        if options.web:
            self._web = self._serve(SideProcess(PAGE, (address, port), setup), "web page", hub, loop)
        if options.foxglove:
            side = SideProcess(FOXGLOVE, (address, options.foxglove_port), setup)
            self._foxglove = self._serve(side, "Foxglove", hub, loop)
        who = " (other users of this machine need it)" if is_loopback(address) and not options.foxglove else ""
        self._invitation = f"pairing code {code}{who}"
        write_error(self._invitation)
        if options.web and not is_loopback(address) and shows_blocks(sys.stderr):
            self._qr = qr_lines(page_address(address, port, code))
            sys.stderr.write("\n".join(self._qr) + "\n")

    def _serve(self, side: SideProcess, name: str, hub: Hub, loop: Loop) -> SideProcess:
        self._closers[name] = side.close
        side.start(hub)
        side.wait(hub, loop.supervisor.sense)
        ticks = loop.supervisor.driver.rate_hz // STATUS_HZ
        self._after.append(_every(ticks, lambda each: side.watch(hub, each.supervisor)))
        self._note(StartCheck(name, True, side.note))
        return side

    def _add_log(self, supervisor: Supervisor) -> None:
        if self.options.log is None:
            return
        from ..records.log import LoopLog
        from ..records.log import about as about_record
        from ..records.recorder import Recorder, record_path

        path, keep_GB = record_path(self.options.log), self.options.keep_GB
        if keep_GB is not None and path == self.options.log:
            raise UserError(f"--keep {keep_GB:g}: only with --log FOLDER, not with the file {path}")
        most_bytes = None if keep_GB is None else int(keep_GB * 1e9)
        recorder = Recorder(path, about_record(self.robot, supervisor), most_bytes=most_bytes)
        self._closers["record"] = recorder.close
        self._recorder = recorder
        self.extra.log = str(recorder.path)
        self._after.insert(0, LoopLog(recorder).tick)
        self._note(StartCheck("record", True, str(recorder.path)))

    def _add_screen(self) -> None:
        if self.options.terminal:
            self._screen = Screen(self._invitation, self._qr)
            self._screen.open()
            self._closers["screen"] = self._screen.close

    def _gate(self, loop: Loop) -> Callable[[Client, Message], bool]:
        """Return the entry for messages; once the session ends, it passes only stops."""

        def receive(client: Client, message: Message) -> bool:
            if self._must_leave and message["type"] != "stop":
                return False
            if message["type"] == "ground":
                return self._choose_ground(loop, client, message)
            return loop.receive(client, message)

        return receive

    def _choose_ground(self, loop: Loop, client: Client, message: Message) -> bool:
        """Put a simulated robot whose joints are off down on another ground; False if that can't be done."""
        stage, supervisor, name = self._parts.stage, loop.supervisor, message["ground"]
        if stage is None or name not in stage.grounds or supervisor.armed or not loop.receive(client, message):
            return False
        stage.choose(name)
        self.extra.ground = name
        supervisor.driver.restart_odometry()
        self._parts.attitude.align()
        return True

    def _after_tick(self, loop: Loop) -> None:
        for each in self._after:
            each(loop)
        if self._must_leave:
            self._leave(loop)

    @property
    def _must_leave(self) -> bool:
        measured = self._measure is not None and self._measure.done
        return measured or (self._leaving is not None and self._leaving.asked > 0)

    def _leave(self, loop: Loop) -> None:
        """Sit down and let go, then end; a second signal ends the loop at once."""
        now_s = loop.clock()
        self._leave_s = self._leave_s or now_s
        loop.supervisor.leave()
        if not loop.supervisor.armed or now_s - self._leave_s > LEAVING_S:
            loop.end()

    def _publish(self, loop: Loop, hub: Hub) -> None:
        self.extra.scripts, self.extra.bad_messages = hub.scripts, hub.bad
        if self.options.log is not None and self._recorder.trouble:
            self.extra.log = self._recorder.trouble
        if self._web is not None:
            self.extra.web, self.extra.pages = self._web.note, self._web.counts.pages
            self.extra.web_counts = self._web.counts.refusals
        if self._foxglove is not None:
            self.extra.foxglove = self._foxglove.note
        self.extra.look_at(self._parts.attitude)
        self.extra.place = None if self._parts.stage is None else self._parts.stage.place()
        news = status(loop, self.extra)
        hub.tell(news)
        if self._screen is not None:
            self._screen.show(news)

    def _page_cpu_s(self) -> float:
        """Return the processor time of the servers' processes."""
        sides = [side.process for side in (self._web, self._foxglove) if side is not None]
        return sum(cpu_seconds(process.pid) for process in sides if process is not None and process.poll() is None)

    def _figures(self, loop: Loop) -> dict[str, Any]:
        figures: dict[str, Any] = {"robot": self.robot.name, "bus": loop.supervisor.bus.kind}
        figures |= self._measure.figures if self._measure and self._measure.done else loop.timing()
        if self._measure:
            figures["failure"] = self._measure.failure
        arbiter = loop.supervisor.arbiter
        figures |= {"obeyed": arbiter.obeyed, "refused": arbiter.refused, "bad_messages": self.extra.bad_messages}
        figures["web_messages"] = self.extra.web_counts
        if self.options.log is not None:
            figures |= {"log": str(self._recorder.path), "log_dropped": self._recorder.dropped}
            figures["log_trouble"] = self._recorder.trouble
        figures["rss_kB"] = resident_kB()
        return figures


def resident_kB() -> int:
    """Return how much memory this process holds."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def _every(ticks: int, call: Callable[[Loop], None]) -> Callable[[Loop], None]:
    """Return a function that calls ``call`` once in so many ticks."""

    def sometimes(loop: Loop) -> None:
        if loop.pacer.ticks % max(1, ticks) == 0:
            call(loop)

    return sometimes


def _repeat(loop: Loop, pad: Gamepad) -> None:
    for message in pad.repeat():
        loop.receive(pad.client, message)
