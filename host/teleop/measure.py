"""A driver that measures: stands up, walks for some seconds, sits down, and leaves figures of the loop behind."""

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..control.arbiter import Client
from ..control.loop import Loop
from ..control.messages import Drive, Message

SEND_S = 0.1
STAND_UP_S = 20.0  # a robot that does not stand by then will not stand at all
SPEED_SHARE = 0.5
CLIENT = Client("script")


class Measure:
    """Drives for ``seconds`` once the robot stands; then ``done`` is true."""

    def __init__(self, seconds: float, vx_m_s: float, page_cpu_s: Callable[[], float] = lambda: 0.0) -> None:
        """``page_cpu_s`` returns the processor time that the page's process has used."""
        self._seconds, self._vx_m_s, self._page_cpu_s = seconds, SPEED_SHARE * vx_m_s, page_cpu_s
        self._began_s: float | None = None
        self._sent_s = self._asked_s = 0.0
        self._busy_s = self._page_s = 0.0
        self._missed_before = 0
        self.done = False
        self.failure = ""
        self.figures: dict[str, Any] = {}

    def tick(self, loop: Loop) -> None:
        """Send what is due."""
        now_s = loop.clock()
        if self.done or now_s - self._sent_s < SEND_S:
            return
        self._sent_s = now_s
        self._asked_s = self._asked_s or now_s
        if loop.supervisor.state == "fault":
            self._give_up(loop, now_s)
        elif self._began_s is None:
            loop.receive(CLIENT, {"type": "posture", "posture": "stand"})
            if loop.supervisor.state == "standing":
                self._begin(loop, now_s)
            elif now_s - self._asked_s > STAND_UP_S:
                self._give_up(loop, now_s)
        elif now_s - self._began_s < self._seconds:
            loop.receive(CLIENT, self._stick())
        else:
            self._end(loop, now_s - self._began_s)

    def _begin(self, loop: Loop, now_s: float) -> None:
        """Begin the figures with the walk: standing up switches torque on, which takes longer than a tick."""
        self._began_s = now_s
        self._busy_s, self._page_s = time.process_time(), self._page_cpu_s()
        self._ticks_before, self._missed_before = loop.pacer.ticks, loop.pacer.missed
        loop.pacer.late_s.clear()
        loop.pacer.busy_s.clear()

    def _give_up(self, loop: Loop, now_s: float) -> None:
        """End the measurement if the robot has a fault."""
        self.done = True
        self.failure = loop.supervisor.reason(now_s) or "the robot does not stand up"
        self.figures = loop.timing()

    def _stick(self) -> Message:
        return {**Drive(self._vx_m_s).message(), "t_ms": time.time() * 1000}

    def _end(self, loop: Loop, took_s: float) -> None:
        self.done = True
        share = (time.process_time() - self._busy_s) / took_s
        page_share = (self._page_cpu_s() - self._page_s) / took_s
        timing = loop.timing()
        timing["ticks"] -= self._ticks_before
        timing["missed"] -= self._missed_before
        errors = loop.supervisor.bus.counters.errors
        self.figures = {"seconds": round(took_s, 2), **timing}
        self.figures |= {"loop_cpu_share": round(share, 4), "page_cpu_share": round(page_share, 4)}
        self.figures["missed_standing_up"] = self._missed_before
        self.figures["bus_errors"] = errors


def cpu_seconds(process: int) -> float:
    """Return the processor time that another process has used (Linux: /proc)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
