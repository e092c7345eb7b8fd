"""The planner's reports on its gait, in sentences: trot or crawl, since when and why; what the crawl has met.

The core keeps codes (planner/handover.py, crawl/state.py); this module has their sentences, for the walk's report, the
pages and the records.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from shared.crawl import state as crawl
from shared.crawl.ground import TROT_LANDINGS
from shared.gait.table import MOVER_CRAWL, MOVER_TROT
from shared.planner import handover
from shared.planner import status as core
from shared.planner.pose import write_margin
from sim2d.notes import Note

from ..robot.gait_names import gait_names
from ..robot.model import LEG_NAMES
from .planner import Driver

_GIVEN_UP = "backing off was stopped: another command came, or joints or attitude became unknown"
_STOPPED = "told to stop, or fallen"
BACKING_OFF, STANDING_STILL, CRAWL = "backing off", "standing still", "crawl"  # phases of an exchange


def gait_now(driver: Driver) -> str:
    """Return how the robot walks: "backing off", "trot", "crawl", or the name of a table gait."""
    status = driver.planner.status
    if status.backing_off:
        return BACKING_OFF
    return {MOVER_TROT: "trot", MOVER_CRAWL: CRAWL}.get(status.mover, gait_names(driver.robot)[status.gait])


def exchange_phase(driver: Driver) -> str:
    """Return how far the crawl has taken over from the trot: "", "backing off", "standing still" or "crawl"."""
    planner = driver.planner
    if planner.status.mover != MOVER_CRAWL:
        return BACKING_OFF if planner.status.backing_off else ""
    return STANDING_STILL if planner.crawl.stage.stage == crawl.STILL else CRAWL


def change_reason(driver: Driver) -> str:
    """Return why trot and crawl last took over from each other, "" if they did not."""
    not_for_it = "the commanded gait or direction is not one for the crawl"
    return {
        handover.REASON_NONE: "",
        handover.REASON_HELD: "held up: its swings meet something again and again",
        handover.REASON_COMMAND: "the crawl was commanded" if exchange_phase(driver) else not_for_it,
        handover.REASON_EVEN: f"even ground under the last {TROT_LANDINGS} footholds",
    }[driver.planner.status.reason]


def margin_m(driver: Driver) -> float:
    """Return how far the centre of mass is inside the polygon of the standing feet, m; below 0: outside."""
    if driver.planner.status.mover != MOVER_CRAWL:
        write_margin(driver.planner)  # computed only here: neither the trot nor standing up uses it
    return driver.scale.metres(driver.planner.status.margin)


def crawl_event(driver: Driver) -> str:
    """Return a sentence on what the crawl met last, "" if nothing."""
    event = driver.planner.crawl.event
    leg = LEG_NAMES[event.leg]
    off_mm = 1000 * driver.scale.metres(event.z)
    return {
        crawl.EVENT_NONE: "",
        crawl.EVENT_LANDED: f"{leg} stands, {off_mm:+.0f} mm from the expected height",
        crawl.EVENT_STEP: f"{leg} met ground {off_mm:.0f} mm above the expected height: it tries further on",
        crawl.EVENT_DROP: f"{leg} found no ground down to {off_mm:.0f} mm: it tries elsewhere",
        crawl.EVENT_CALF: f"{leg} had its calf on an edge: it lifts and goes further on",
        crawl.EVENT_RISER: f"{leg} hit a riser: it goes back and higher",
        crawl.EVENT_NO_GROUND: f"{leg} found no ground down to {off_mm:.0f} mm and stays in the air",
        crawl.EVENT_SINKS: f"{leg} comes down {off_mm:+.0f} mm from its last foothold: the body sank over it",
        crawl.EVENT_RIM: f"{leg} met a rim, {off_mm:+.0f} mm from the expected height: it tries as far again",
        crawl.EVENT_DIAGONALS: f"{leg} lifts although the diagonals do not carry the load that they should",
    }[event.code]


class GaitWatch:
    """Checks a planner after each tick and keeps a note whenever trot and crawl take over from each other."""

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self.restart()

    def restart(self) -> None:
        """Forget the notes; seconds count from now."""
        self.notes: list[Note] = []
        self._ticks, self._before = 0, exchange_phase(self._driver)

    def look(self) -> None:
        """Note a tick's change, if there is one."""
        now, before = exchange_phase(self._driver), self._before
        self._ticks += 1
        if now == before:
            return
        self._before = now
        if now != STANDING_STILL:
            time_s = round(self._ticks / self._driver.rate_hz, 3)
            self.notes.append(Note(time_s, gait_now(self._driver), self._why(before, now)))

    def _why(self, before: str, now: str) -> str:
        status = self._driver.planner.status
        if not now and before == BACKING_OFF:
            return _GIVEN_UP
        if not now and status.state != core.WALKING:
            return _STOPPED
        return change_reason(self._driver)


def notes_json(notes: Iterable[Note]) -> list[dict[str, Any]]:
    """Return notes as plain values for JSON."""
    return [{"time_s": note.time_s, "to": note.what, "reason": note.why} for note in notes]


def change_lines(changes: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return the changes of a walk as rows to print."""
    return [(f"at {change['time_s']:.1f} s: {change['to']}", change["reason"]) for change in changes]
