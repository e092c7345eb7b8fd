"""The figures of teleoperation, measured from outside on the whole command.

Emulated servos behind their terminal, the page in its process, a real browser, a terminal, a script.

Times of the terminal and the script run from the moment before a key or line is written to the return of the write of
the packet that obeys it, both on this machine's monotonic clock. The page's run from the browser's own time stamp of
the event; a gamepad has none, so its runs from the frame in which the browser shows the change.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, Protocol

from ... import NAME
from ...control.pacer import figures_ms
from ...util.errors import NOT_ACHIEVED, UserError
from . import browser
from .watched import Status, Watched, free_port

MOST_CPU_SHARE = 0.25
COMMAND_MS, STOP_MS = 30.0, 25.0
GROWN_KB = 2000  # the allocators' own coming and going (measured: a few hundred)
MESSAGES, CONNECTIONS = 10_000, 200
SETTLE_S = 1.3  # counts of the page's process come once a second
STAND_S = 20.0
PUSHES = 5  # made at most until one is not ended by a fault


@dataclass(frozen=True)
class Row:
    """A figure, its limit, and details."""

    what: str
    value: float
    at_most: float
    unit: str
    detail: str = ""

    @property
    def reached(self) -> bool:
        """True if it is good enough."""
        return self.value <= self.at_most


@dataclass
class Bench:
    """All figures, and those that could not be measured here, with the reason."""

    rows: list[Row]
    skipped: dict[str, str]

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        rows = [{**asdict(row), "reached": row.reached} for row in self.rows]
        return {"figures": rows, "skipped": self.skipped}


class Source(Protocol):
    """A driver for measurements: pushes a stick, lets it go, stops, stands up, resets the stop."""

    def __call__(self, what: str) -> None:
        """Do one of push, let go, stop, stand, reset."""


KEYS = {"push": "w", "let go": "5", "stop": " ", "stand": "t", "reset": "r"}  # a digit sets the sticks to rest
LINES: dict[str, dict[str, Any]] = {
    **{what: {"type": "drive", "vx_m_s": speed, "vy_m_s": 0, "wz_rad_s": 0, "pose": [0] * 6}
       for what, speed in (("push", 0.02), ("let go", 0.0))},
    "stop": {"type": "stop"}, "stand": {"type": "posture", "posture": "stand"}, "reset": {"type": "reset"},
}


def run_bench(seconds: float, presses: int, done: Callable[[str], None]) -> Bench:
    """Measure everything; ``done`` gets the name of each measurement."""
    bench = Bench([], {})
    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder:
        done(f"walking for {seconds:g} s")
        bench.rows += _walk(seconds)
        for name, opener in SOURCES.items():
            done(name)
            try:
                bench.rows += _latencies(Path(folder), name, opener, presses)
            except Skipped as why:
                bench.skipped[name] = str(why)
        done(f"{MESSAGES} bad messages")
        bench.rows += _noise(Path(folder))
    return bench


def _walk(seconds: float) -> list[Row]:
    """Walk while the page is served and one script watches."""
    command = [sys.executable, "-m", f"{NAME}.cli", "teleop", "--sim", "--web", "--listen", f"127.0.0.1:{free_port()}"]
    command += ["--measure", f"{seconds:g}", "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if not done.stdout:
        raise UserError(f"caramelo teleop did not start: {done.stderr.strip()}", NOT_ACHIEVED)
    figures = json.loads(done.stdout)
    if figures["failure"]:
        raise UserError(f"the walk ended: {figures['failure']}", NOT_ACHIEVED)
    late, busy = figures["late_ms"], figures["busy_ms"]
    share = figures["loop_cpu_share"] + figures["page_cpu_share"]
    detail = f"{figures['ticks']} ticks, late {late['p99']:.2f} ms (p99), busy {busy['p99']:.1f} ms (p99)"
    return [
        Row(f"missed deadlines in {seconds:g} s", figures["missed"], 0, "", detail),
        Row("processor, loop and page", round(100 * share, 1), 100 * MOST_CPU_SHARE, "% of one core"),
    ]


class Skipped(Exception):
    """The reason why something can't be measured here."""


@contextmanager
def _keyboard(folder: Path) -> Iterator[tuple[Watched, Source]]:
    with Watched(folder, terminal=True) as teleop:
        yield teleop, lambda what: teleop.keys(KEYS[what])


@contextmanager
def _script(folder: Path) -> Iterator[tuple[Watched, Source]]:
    with Watched(folder) as teleop:
        yield teleop, lambda what: teleop.say(**LINES[what])


def _page(act: Callable[[Any, str], None]) -> Callable[[Path], Any]:
    @contextmanager
    def opener(folder: Path) -> Iterator[tuple[Watched, Source]]:
        if why := browser.missing():
            raise Skipped(why)
        with ExitStack() as stack:
            teleop = stack.enter_context(Watched(folder))
            page = stack.enter_context(browser.open_page(teleop.url))
            yield teleop, partial(act, page)

    return opener


SOURCES: dict[str, Callable[[Path], Any]] = {
    "keyboard": _keyboard,
    "script": _script,
    "page, key": _page(browser.by_key),
    "page, stick and STOP": _page(browser.by_stick),
    "page, gamepad": _page(browser.by_pad),
}


def _latencies(folder: Path, name: str, opener: Callable[[Path], Any], presses: int) -> list[Row]:
    """Return how long a source's sticks and stops take to reach the packet."""
    chance = Random("pauses")
    with opener(folder) as (teleop, source):
        steered_s = [_press(teleop, source, chance) for _ in range(presses)]
        stopped_s = [_stop(teleop, source, chance) for _ in range(presses)]
        if name.startswith("page"):
            figures = teleop.stop()
            steered = figures["command_to_packet_ms"]["web"]
            stopped = figures["stop_to_packet_ms"]["web"]
        else:
            steered, stopped = figures_ms(steered_s), figures_ms(stopped_s)
    return [
        _latency(f"{name}: stick to packet", steered, COMMAND_MS),
        _latency(f"{name}: stop to torque off", stopped, STOP_MS),
    ]


def _latency(what: str, figures: dict[str, float], at_most: float) -> Row:
    detail = f"median {figures['p50']:.1f}, at most {figures['max']:.1f}, {figures['count']:.0f} times"
    return Row(what, round(figures["p99"], 1), at_most, "ms (p99)", detail)


def _press(teleop: Watched, source: Source, chance: Random) -> float:
    """Push the stick at any moment of a tick, and let it go; return how long the push took, s.

    A push during which a fault ended the walk measures nothing and is made again. UserError after ``PUSHES`` of them.
    """
    for _ in range(PUSHES):
        teleop.stand(source, lambda status: status["state"] in ("standing", "walking"), STAND_S)
        time.sleep(chance.uniform(0.02, 0.06))
        taken_s = _moved(teleop, source, "push")
        if taken_s is not None and _moved(teleop, source, "let go") is not None:
            return taken_s
    raise UserError(f"a fault ended each of {PUSHES} walks: {teleop.status()['reason']}", NOT_ACHIEVED)


def _moved(teleop: Watched, source: Source, what: str) -> float | None:
    """Move the stick and return how long that took to reach a packet, s; None if a fault came first."""
    moved_s = time.monotonic()
    source(what)
    sent = _since("steered_at_s", moved_s)
    status = teleop.wait(lambda status: sent(status) or status["state"] == "fault")
    taken_s: float | None = status["timing"]["steered_at_s"] - moved_s if sent(status) else None
    return taken_s


def _stop(teleop: Watched, source: Source, chance: Random) -> float:
    """Stop while the robot rises, and reset."""
    teleop.stand(source, lambda status: status["armed"], STAND_S)
    time.sleep(chance.uniform(0.02, 0.06))
    pulled_s = time.monotonic()
    source("stop")
    status = teleop.wait(_since("stopped_at_s", pulled_s))
    source("reset")
    teleop.wait(lambda status: status["stop"] is None)
    taken_s: float = status["timing"]["stopped_at_s"] - pulled_s
    return taken_s


def _since(key: str, time_s: float) -> Callable[[Status], bool]:
    """Return what finds a status whose packet went out after a time."""
    return lambda status: (status["timing"][key] or 0.0) >= time_s


def _noise(folder: Path) -> list[Row]:
    """Send bad messages over many connections, twice: the first round fills all buffers."""
    from .noise import make_noise, memory_kB

    with Watched(folder) as teleop:
        make_noise(teleop.url, MESSAGES, CONNECTIONS)
        time.sleep(SETTLE_S)
        before, first_kB = teleop.status(), memory_kB(teleop.process.pid)
        make_noise(teleop.url, MESSAGES, CONNECTIONS)
        time.sleep(SETTLE_S)
        after, last_kB = teleop.status(), memory_kB(teleop.process.pid)
    ticks, missed = (after["timing"][key] - before["timing"][key] for key in ("ticks", "missed"))
    refused = after["web_counts"]["malformed"] - before["web_counts"]["malformed"]
    name, detail = f"{MESSAGES} bad messages", f"{ticks} ticks, {CONNECTIONS} connections, {refused} times hung up"
    return [
        Row(f"{name}: missed deadlines", missed, 0, "", detail),
        Row(f"{name}: obeyed", after["obeyed"] - before["obeyed"], 0, ""),
        Row(f"{name}: memory growth", max(0, last_kB - first_kB), GROWN_KB, "kB"),
    ]
