"""Trot and crawl are exchanged in sentences: every code of the core has its words, every exchange its note."""

import pytest

from host.control.gait_changes import (
    GaitWatch,
    change_lines,
    change_reason,
    crawl_event,
    gait_now,
    margin_m,
    notes_json,
)
from host.control.planner import Driver
from host.robot.file import load_robot
from shared.crawl import state as crawl
from shared.gait.table import MOVER_CRAWL, MOVER_TROT
from shared.planner import handover
from shared.planner import status as core

REASONS = [value for name, value in vars(handover).items() if name.startswith("REASON_") and name != "REASON_NONE"]
EVENTS = [value for name, value in vars(crawl).items() if name.startswith("EVENT_") and name != "EVENT_NONE"]


@pytest.fixture
def driver():
    return Driver(load_robot("caramelo"))


# What has the ticks, whether the trot backs off, the stage of the crawl
TROTS, BACKS = (MOVER_TROT, 0, crawl.SHIFT), (MOVER_TROT, 1, crawl.SHIFT)
WAITS, CRAWLS = (MOVER_CRAWL, 0, crawl.STILL), (MOVER_CRAWL, 0, crawl.LIFT)


def put(driver, phase):
    """Bring a planner into one of TROTS .. CRAWLS."""
    status = driver.planner.status
    status.mover, status.backing_off, driver.planner.crawl.stage.stage = phase


def seen(driver, *states):
    """Return the notes of a watch that sees (TROTS .. CRAWLS, reason, planner's state) tick by tick."""
    watch = GaitWatch(driver)
    for phase, reason, state in states:
        status = driver.planner.status
        put(driver, phase)
        status.reason, status.state = reason, state
        watch.look()
    return watch.notes


@pytest.mark.parametrize("reason", REASONS)
def test_every_reason_has_a_sentence(driver, reason):
    driver.planner.status.reason = reason
    for phase in (TROTS, WAITS, CRAWLS, BACKS):
        put(driver, phase)
        assert len(change_reason(driver).split()) > 3


@pytest.mark.parametrize("event", EVENTS)
def test_every_event_of_the_crawl_has_a_sentence_with_its_leg(driver, event):
    driver.planner.crawl.event.code = event
    driver.planner.crawl.event.leg = 3
    assert crawl_event(driver).startswith("RL ")


def test_a_new_robot_has_nothing_to_tell(driver):
    assert (change_reason(driver), crawl_event(driver), seen(driver)) == ("", "", [])
    assert gait_now(driver) == "paper-trot"


def test_the_way_over_an_edge_is_told_once_each(driver):
    held, even = handover.REASON_HELD, handover.REASON_EVEN
    notes = seen(
        driver,
        (TROTS, handover.REASON_NONE, core.WALKING),
        (BACKS, held, core.WALKING),
        (BACKS, held, core.STANDING),
        (WAITS, held, core.STANDING),
        (CRAWLS, held, core.WALKING),
        (CRAWLS, held, core.WALKING),
        (TROTS, even, core.WALKING),
    )
    assert [(note.time_s, note.what) for note in notes] == [(0.04, "backing off"), (0.1, "crawl"), (0.14, "trot")]
    assert notes[0].why == "held up: its swings meet something again and again"
    assert notes[2].why == "even ground under the last 16 footholds"


def test_what_ends_without_a_reason_of_the_planner_is_told_too(driver):
    held = handover.REASON_HELD
    given_up = seen(driver, (BACKS, held, core.WALKING), (TROTS, held, core.WALKING))
    assert "was stopped" in given_up[-1].why
    stopped = seen(driver, (CRAWLS, held, core.WALKING), (TROTS, held, core.SITTING))
    assert "told to stop" in stopped[-1].why


def test_notes_become_json_and_rows(driver):
    notes = seen(driver, (WAITS, handover.REASON_COMMAND, 2), (CRAWLS, handover.REASON_COMMAND, 3))
    rows = notes_json(notes)
    assert rows == [{"time_s": 0.04, "to": "crawl", "reason": "the crawl was commanded"}]
    assert change_lines(rows) == [("at 0.0 s: crawl", "the crawl was commanded")]


def test_the_margin_is_told_while_it_stands_and_while_it_trots(driver):
    def margins_m(mode, seconds, **speed):
        driver.set_command(mode=mode, gait="trot", **speed)
        told, goals = [], None
        for _ in range(round(seconds * driver.rate_hz)):
            driver.sense(goals, 0.0, 0.0)
            goals = driver.step()
            told.append(margin_m(driver))
        return told

    assert margins_m("stand", 5.0)[-1] > 0.05
    assert min(margins_m("walk", 3.0, vx_m_s=0.1)) < 0.01, "on two feet"
    assert margins_m("stand", 3.0)[-1] > 0.05, "after a trot, too"
