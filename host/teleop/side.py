"""A server's process, kept running: started, watched, and started again when it ends or falls silent.

One serves the page, one Foxglove's viewers; each speaks for its clients over a socket of lines (hub.py).
All this happens in the loop's own thread, and only the first start waits.
"""

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from .. import NAME
from ..bus.base import Fault
from ..control.supervisor import Supervisor
from ..util.child import end_child
from ..util.errors import UserError
from .hub import Hub

START_S = 60.0  # usually a second, but longer beside other work, because the process has a low priority (chosen)
END_S = 3.0
DEFAULT = "127.0.0.1:8080"
SILENT_S = 5.0  # it reports once a second (host/teleop/web/process.py); a busy machine may delay it (chosen)
AGAIN_S = 1.0  # between its end and the next start
STEADY_S = 5.0  # after this time it counts as running again
UNREACHABLE_S = 20.0  # the longest time in which nobody can stop the robot from the page (chosen)


@dataclass
class Counts:
    """The process's report, once a second; ``pages``: its clients."""

    pages: int = 0
    refusals: dict[str, int] = field(default_factory=dict)
    trouble: str = ""


@dataclass(frozen=True)
class Kind:
    """``source`` is its clients' source (arbiter.PRIORITY) and the server's folder, ``needs`` its library."""

    source: str
    needs: str
    name: str
    scheme: str


PAGE = Kind("web", "aiohttp", "page", "http")
FOXGLOVE = Kind("foxglove", "foxglove", "Foxglove server", "ws")


class SideProcess:
    """The process behind a server.

    ``note`` is its line in the status: the address, or why there is none. ``setup`` is the data that the process gets.
    """

    def __init__(
        self,
        kind: Kind,
        listen: tuple[str, int],
        setup: dict[str, Any],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        import_module(kind.needs)  # here, so that a missing extra is reported before anything runs
        self._kind, (self._address, self._port) = kind, listen
        self._setup = {**setup, "listen": self._address, "port": self._port}
        self._clock = clock
        self.process: subprocess.Popen[bytes] | None = None
        self.note, self.counts = "", Counts()
        self.starts = 0
        self._runs = self._listens = False  # since its start; since its own report
        self._began_s = self._heard_s = self._ended_s = 0.0
        self._lost_s: float | None = None  # since when it has not run steadily
        self._why = ""
        self._errors = os.memfd_create("caramelo-side")  # its last words; in memory, so that nothing waits for a disk

    def start(self, hub: Hub) -> None:
        """Start the process and give the hub its end of their common socket; the process reports how it goes."""
        ours, theirs = socket.socketpair()
        os.ftruncate(self._errors, 0)
        # In a session of its own, because the loop handles Ctrl-C in the terminal.
        self.process = subprocess.Popen(
            [sys.executable, "-m", f"{NAME}.teleop.server", self._kind.source, str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
        )
        theirs.close()
        ours.sendall(json.dumps(self._setup).encode() + b"\n")
        self.starts += 1
        self._runs = True
        self._began_s = self._heard_s = self._clock()
        hub.add_side(self._kind.source, ours, self._hear)

    def wait(self, hub: Hub, meanwhile: Callable[[], object] = lambda: None) -> None:
        """Wait until it serves for the first time; UserError if it can't.

        ``meanwhile`` is called many times a second, so that the joints' values do not grow old while this waits.
        """
        while not self._listens and not self._why and self._clock() - self._began_s < START_S:
            hub.poll(0.02)
            meanwhile()
            if not hub.has_side(self._kind.source):
                self._why = self._why or f"the {self._kind.name}'s process did not start: {self._last_words()}"
        if not self._listens:
            self.close()
            raise UserError(self._why or f"the {self._kind.name}'s process has reported nothing for {START_S:.0f} s")

    def watch(self, hub: Hub, supervisor: Supervisor) -> None:
        """Check that it lives, else start it again; sit the robot down once it is out of reach for too long."""
        now_s = self._clock()
        if self._runs and not hub.has_side(self._kind.source) and self._is_over():
            self._lose(hub, self._why or self._last_words())
        elif self._runs and now_s - self._heard_s > (SILENT_S if self._listens else START_S):
            self._lose(hub, f"the {self._kind.name}'s process has reported nothing for {now_s - self._heard_s:.0f} s")
        elif self._runs and self._listens and now_s - self._began_s > STEADY_S:
            self._lost_s = None
        elif not self._runs and now_s - self._ended_s > AGAIN_S and self._is_over():
            self.start(hub)
        if self._lost_s is not None and now_s - self._lost_s > UNREACHABLE_S:
            self._stand_down(supervisor, now_s - self._lost_s)

    def close(self) -> None:
        """End it; the hub has hung up."""
        if self.process is not None:
            end_child(self.process, END_S)
            self.process = None

    def _is_over(self) -> bool:
        return self.process is None or self.process.poll() is not None

    def _hear(self, news: dict[str, Any]) -> None:
        """Take the process's report on itself."""
        self._heard_s = self._clock()
        if "error" in news:
            self._why = str(news["error"])
        elif "listens" in news:
            self._listens, self.note, self._why = True, self._url(), ""
        else:
            refusals = {key: int(news[key]) for key in ("malformed", "limited", "refused")}
            self.counts = Counts(int(news["pages"]), refusals, str(news["trouble"]))
            self.note = self._url() + (f" ({self.counts.trouble})" if self.counts.trouble else "")

    def _lose(self, hub: Hub, why: str) -> None:
        """Remove all that is left of a process that is gone or hangs."""
        assert self.process is not None
        hub.lose_side(self._kind.source)
        self.process.kill()
        self._runs = self._listens = False
        self._ended_s = self._clock()
        self._lost_s = self._heard_s if self._lost_s is None else self._lost_s
        self._why, self.counts = "", Counts(0, self.counts.refusals)
        self.note = f"no {self._kind.name}: {why}; start {self.starts + 1} follows"

    def _stand_down(self, supervisor: Supervisor, lost_s: float) -> None:
        """Sit down and let go if the robot stands, nobody drives, and nobody can reach it through this server."""
        if supervisor.armed and supervisor.safety.first is None and supervisor.arbiter.driver is None:
            sentence = f"the {self._kind.name} has been out of reach for {lost_s:.0f} s, and nobody else drives"
            supervisor.safety.raise_fault(Fault("sit", self._kind.name, sentence))

    def _last_words(self) -> str:
        """Return the last line that it wrote before it died, or how it died."""
        assert self.process is not None
        text = os.pread(self._errors, 1 << 16, max(0, os.fstat(self._errors).st_size - (1 << 16)))
        lines = text.decode(errors="replace").split("\n")
        said = next((line.strip() for line in reversed(lines) if line.strip()), "")
        code = self.process.poll()
        ended = "" if code is None else f"ended by signal {-code}" if code < 0 else f"ended with code {code}"
        return said or ended or "its connection is closed"

    def _url(self) -> str:
        if self._address in ("0.0.0.0", "::"):
            return f"{self._kind.scheme}://{socket.gethostname()}.local:{self._port}, or this machine's address"
        host = f"[{self._address}]" if ":" in self._address else self._address
        return f"{self._kind.scheme}://{host}:{self._port}"


def listen_address(text: str) -> tuple[str, int]:
    """Return address and port of ADDR, ADDR:PORT or [ADDR]:PORT."""
    address, port = text, DEFAULT.rpartition(":")[2]
    if text.startswith("["):
        address, _, rest = text[1:].partition("]")
        port = rest.lstrip(":") or port
    elif text.count(":") == 1:
        address, _, port = text.partition(":")
    if not address or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UserError(f"--listen {text}: allowed: an address, or address:port such as {DEFAULT}")
    return address, int(port)
