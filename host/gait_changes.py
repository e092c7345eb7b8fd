"""What the planner says of its gait, in sentences: trot or crawl, since when and why; what the crawl has met.

The core keeps codes (planner/handover.py, crawl/state.py); here they get their words, for the walk's report,
the pages and the records.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from shared.crawl import state as crawl
from shared.gait.gaits import GAIT_NAMES
from shared.planner import handover
from shared.planner import status as core
from shared.trot import trot as adaptive
from shared.trot.trot import BEHIND_STEP
from sim2d.notes import Note

from .drive import Driver
from .robot_model import LEG_NAMES

_GIVEN_UP = "backing off was given up: another command came, or joints or attitude became unknown"
_STOPPED = "told to stop, or fallen"


def gait_now(driver: Driver) -> str:
    """Return what is walked: "backing off", "crawl", or the name of the gait."""
    status = driver.planner.status
    state = status.climb
    if state == core.CLIMB_OFF:
        return GAIT_NAMES[status.gait]
    return "backing off" if state == core.CLIMB_BACK else "crawl"


def change_reason(driver: Driver) -> str:
    """Return why trot and crawl were last exchanged, "" if they were not."""
    params = driver.planner.params
    behind_mm = 1000 * driver.scale.metres(params.leg_length * 3 >> 5)
    held_s = params.advice_ticks / BEHIND_STEP / driver.rate_hz
    crawls = driver.planner.status.climb != core.CLIMB_OFF
    return {
        handover.REASON_NONE: "",
        handover.REASON_BEHIND: f"held up: more than {behind_mm:.0f} mm behind the commanded way for {held_s:.1f} s",
        handover.REASON_COMMAND: "the crawl was commanded"
        if crawls
        else "a gait or a way was commanded that is not the crawl's",
        handover.REASON_EVEN: f"even ground under the last {handover.LEGS_EVEN} footholds",
    }[driver.planner.status.reason]


def advice(driver: Driver) -> str:
    """Return what the adaptive trot advises, "" if it does well."""
    return {
        adaptive.ADVICE_FINE: "",
        adaptive.ADVICE_BEHIND: "it does not get on: another gait may",
        adaptive.ADVICE_TILTED: "it tilts a lot on this ground: the crawl is safer",
    }[driver.planner.status.advice]


def margin_m(driver: Driver) -> float:
    """Return how far the centre of mass is inside the polygon of the standing feet, m; below 0: outside."""
    return driver.scale.metres(driver.planner.status.margin)


def crawl_event(driver: Driver) -> str:
    """Return what the crawl met last, "" if nothing."""
    event = driver.planner.climb.event
    leg = LEG_NAMES[event.leg]
    off_mm = 1000 * driver.scale.metres(event.z)
    return {
        crawl.EVENT_NONE: "",
        crawl.EVENT_LANDED: f"{leg} stands, {off_mm:+.0f} mm off the height expected",
        crawl.EVENT_STEP: f"{leg} met ground {off_mm:.0f} mm above the height expected: it tries further on",
        crawl.EVENT_DROP: f"{leg} found no ground down to {off_mm:.0f} mm: it tries elsewhere",
        crawl.EVENT_SHIN: f"{leg} stood on an edge with its shin: it lifts and goes further on",
        crawl.EVENT_RISER: f"{leg} ran into a riser: it goes back and higher",
        crawl.EVENT_NO_GROUND: f"{leg} found no ground down to {off_mm:.0f} mm and is left hanging",
        crawl.EVENT_WARP: f"{leg} lifts although the diagonals do not carry what they should",
    }[event.code]


class GaitWatch:
    """Looks at a planner after each tick and keeps a note whenever trot and crawl are exchanged."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self.restart()

    def restart(self) -> None:
        """Forget the notes; the seconds count from here."""
        self.notes: list[Note] = []
        self._ticks, self._before = 0, self._driver.planner.status.climb

    def look(self) -> None:
        """Take note of a tick."""
        now, before = self._driver.planner.status.climb, self._before
        self._ticks += 1
        if now == before:
            return
        self._before = now
        if now != core.CLIMB_READY:
            time_s = round(self._ticks / self._driver.rate_hz, 3)
            self.notes.append(Note(time_s, gait_now(self._driver), self._why(before, now)))

    def _why(self, before: int, now: int) -> str:
        status = self._driver.planner.status
        if now == core.CLIMB_OFF and before == core.CLIMB_BACK:
            return _GIVEN_UP
        if now == core.CLIMB_OFF and status.state != core.WALKING:
            return _STOPPED
        return change_reason(self._driver)


def notes_json(notes: Iterable[Note]) -> list[dict[str, Any]]:
    """Return notes as plain values for JSON."""
    return [{"time_s": note.time_s, "to": note.what, "reason": note.why} for note in notes]


def change_lines(changes: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return the changes of a walk as rows for people."""
    return [(f"at {change['time_s']:.1f} s: {change['to']}", change["reason"]) for change in changes]
