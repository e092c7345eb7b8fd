"""The terminal: keys without Enter, and a screen with the state, the reason, the key map and the loop's figures.

Painting has its own thread, so a slow or halted terminal (ssh over a bad line, Ctrl-S) holds nothing up; it paints the
newest status. During a drive only that thread writes to the terminal.
"""

import sys
import termios
import threading
import tty
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from shutil import get_terminal_size
from typing import Any

from ..robot.model import JOINT_NAMES, LEG_NAMES
from ..util.console import plain
from .keyboard import HELP

REPAINT_S = 0.2
HOME, CLEAR_LINE, CLEAR_REST = "\x1b[H", "\x1b[K", "\x1b[J"
ENTER, LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
BOLD, RED, GREEN, PLAIN = "\x1b[1m", "\x1b[1;97;41m", "\x1b[1;32m", "\x1b[0m"


@contextmanager
def raw_keys(descriptor: int) -> Iterator[None]:
    """Read keys one by one without echo; Ctrl-C still interrupts. The end restores the terminal."""
    before = termios.tcgetattr(descriptor)
    try:
        tty.setcbreak(descriptor)
        yield
    finally:
        with suppress(termios.error):  # a terminal that is gone needs no restoring
            termios.tcsetattr(descriptor, termios.TCSANOW, before)  # not after pending output: a halted one takes none


class Screen:
    """Paints the newest status a few times a second until it is closed, or the terminal is gone."""

    def __init__(self, secret: str, picture: Sequence[str]) -> None:
        """``secret``: the page's pairing code, shown only here; ``picture``: shown if there is room."""
        self._secret, self._picture = secret, list(picture)
        self._status: dict[str, Any] = {}
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._paint, name="screen", daemon=True)

    def open(self) -> None:
        """Switch to the terminal's alternate screen and start."""
        self._thread.start()

    def show(self, status: dict[str, Any]) -> None:
        """Keep the newest status."""
        self._status = status

    def close(self) -> None:
        """Return to the main screen; this waits as long as the terminal does."""
        self._done.set()
        self._thread.join()

    def _paint(self) -> None:
        there = self._write(ENTER)
        while there and not self._done.wait(REPAINT_S):
            if self._status:
                lines = screen_lines(self._status, self._secret)
                if len(lines) + len(self._picture) < get_terminal_size().lines:
                    lines += self._picture
                text = "".join(f"{line}{CLEAR_LINE}\n" for line in lines)
                there = self._write(HOME + text + CLEAR_REST)
        if there:
            self._write(LEAVE)

    def _write(self, text: str) -> bool:
        """Write to the terminal; False if it is gone, which must not end a drive before the robot sits."""
        try:
            sys.stdout.write(text)
            sys.stdout.flush()
        except OSError:
            return False
        return True


def screen_lines(status: dict[str, Any], secret: str = "") -> list[str]:
    """Return the screen's lines. Texts of the status may come from anywhere, so control characters are escaped."""
    status = {key: " ".join(plain(value).split()) if isinstance(value, str) else value for key, value in status.items()}
    timing, driver = status["timing"], status["driver"]
    mark = RED if status["stop"] or status["fault"] else GREEN if not status["reason"] else BOLD
    who = "nobody" if driver is None else " ".join(str(part) for part in driver if part)
    attitude = status["attitude_rad"]
    unknown = f"unknown: {status['attitude_note']}" if status["attitude_note"] else "unknown"
    tilt = unknown if attitude is None else "roll {:+.1f}, pitch {:+.1f} deg".format(*(57.2958 * a for a in attitude))
    margin = "" if status["margin_m"] is None else f"   stability margin {1000 * status['margin_m']:+.0f} mm"
    volts = "unknown" if status["battery_V"] is None else f"{status['battery_V']:.1f} V"
    lines = [
        f"{mark} {status['state']} {PLAIN} {status['reason']}",
        status["remark"],
        f"driver {who}   gait {status['gait']}   balance {'on' if status['balance'] else 'off'}{margin}",
        "speed {:+.3f} {:+.3f} m/s, turning {:+.2f} rad/s".format(*status["speed"]),
        f"attitude {tilt}   battery {volts}   bus errors {status['bus_errors']} of {status['bus_asked']}",
        f"{timing['rate_hz']} Hz   ticks {timing['ticks']}   missed {timing['missed']}   {status['web']}   {secret}",
        "",
        f"{'':4}" + "".join(f"{name:>24}" for name in JOINT_NAMES),
    ]
    lines += [_leg_line(status, leg) for leg in range(4)]
    return [*lines, "", *key_lines()]


def key_lines() -> list[str]:
    """Return the key map in two columns."""
    cells = [f"{BOLD}{keys:>8}{PLAIN}  {meaning:<32}" for keys, meaning in HELP]
    half = (len(cells) + 1) // 2
    right = [*cells[half:], ""]
    return [a + b for a, b in zip(cells[:half], right, strict=False)]


def _leg_line(status: dict[str, Any], leg: int) -> str:
    cells = []
    for joint in range(3 * leg, 3 * leg + 3):
        angle, load, heat = status["joints_rad"][joint], status["load"][joint], status["temperature_C"][joint]
        cells.append(f"{57.2958 * angle:+8.1f} deg {100 * load:+4.0f} % {heat:3.0f} C")
    return f"{LEG_NAMES[leg]:4}" + "".join(f"{cell:>24}" for cell in cells)
