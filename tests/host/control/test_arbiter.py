"""Who drives, when a command is too old, and what a stop does."""

import pytest

from host.control.arbiter import DEAD_MAN_S, LEFT_S, Arbiter

from .rig import AHEAD, KEYS, OTHER_PAGE, PAD, PAGE, RESET, SCRIPT, STAND, STILL, STOP


@pytest.fixture
def arbiter():
    return Arbiter(gait="trot", gaits=("trot", "amble"))


def test_first_come_drives_and_a_second_page_does_not(arbiter):
    assert arbiter.handle(PAGE, AHEAD, 0.0)
    assert not arbiter.handle(OTHER_PAGE, {**AHEAD, "vx_m_s": -0.1}, 0.1)
    assert (arbiter.driver, arbiter.drive.vx_m_s, arbiter.refused) == (PAGE, 0.05, 1)
    assert arbiter.refusal == "web 1 drives"


@pytest.mark.parametrize(("lower", "higher"), [(SCRIPT, PAGE), (PAGE, PAD), (PAD, KEYS)])
def test_priority(arbiter, lower, higher):
    arbiter.handle(lower, AHEAD, 0.0)
    assert arbiter.handle(higher, STILL, 0.1)
    assert arbiter.driver == higher
    assert not arbiter.handle(lower, AHEAD, 0.2)
    assert not arbiter.update(0.2).moves


def test_the_controls_are_free_once_the_driver_lets_go_or_has_left(arbiter):
    arbiter.handle(PAGE, AHEAD, 0.0)
    assert not arbiter.handle(OTHER_PAGE, {"type": "release"}, 0.1)
    assert arbiter.handle(PAGE, {"type": "release"}, 0.1)
    assert arbiter.handle(OTHER_PAGE, AHEAD, 0.2)
    assert not arbiter.handle(PAGE, AHEAD, 0.2 + LEFT_S - 0.01)
    assert arbiter.handle(PAGE, AHEAD, 0.2 + LEFT_S + 0.01)


def test_dead_man(arbiter):
    arbiter.handle(PAGE, AHEAD, 1.0)
    assert arbiter.update(1.0 + DEAD_MAN_S - 0.001).moves
    assert not arbiter.update(1.0 + DEAD_MAN_S + 0.001).moves
    assert arbiter.driver == PAGE
    arbiter.update(1.0 + LEFT_S + 0.01)
    assert arbiter.driver is None


def test_a_lost_driver_stops_at_once_and_keeps_the_pose(arbiter):
    arbiter.handle(PAGE, {**AHEAD, "pose": [0.01, 0, 0, 0, 0, 0]}, 0.0)
    arbiter.drop(OTHER_PAGE)
    assert arbiter.update(0.01).moves
    arbiter.drop(PAGE)
    drive = arbiter.update(0.01)
    assert (drive.moves, drive.pose[0], arbiter.driver) == (False, 0.01, None)


@pytest.mark.parametrize("who", [SCRIPT, PAGE, OTHER_PAGE, PAD, KEYS], ids=str)
def test_anybody_stops_and_it_stays_stopped(arbiter, who):
    arbiter.handle(KEYS, STAND, 0.0)
    arbiter.handle(KEYS, AHEAD, 0.0)
    assert arbiter.handle(who, STOP, 0.1)
    assert arbiter.stop.client == who
    assert arbiter.handle(SCRIPT if who is not SCRIPT else PAGE, STOP, 0.2)
    assert arbiter.stop.client == who, "the first is kept"
    assert not arbiter.handle(KEYS, STAND, 0.3)
    assert (arbiter.posture, arbiter.obeyed, arbiter.refused) == ("rest", 2, 1)


def test_only_who_may_drive_resets_and_nothing_comes_back_by_itself(arbiter):
    arbiter.handle(PAGE, STAND, 0.0)
    arbiter.handle(OTHER_PAGE, STOP, 0.1)
    assert not arbiter.handle(OTHER_PAGE, RESET, 0.2)
    assert arbiter.stop is not None
    assert arbiter.handle(PAGE, RESET, 0.2)
    assert (arbiter.stop, arbiter.posture, arbiter.drive.moves) == (None, "rest", False)
    assert arbiter.handle(PAGE, STAND, 0.3)


def test_gait_and_balance(arbiter):
    assert arbiter.handle(PAGE, {"type": "gait", "gait": "amble"}, 0.0)
    assert not arbiter.handle(PAGE, {"type": "gait", "gait": "gallop"}, 0.0)
    assert (arbiter.gait, arbiter.refusal) == ("amble", "no such gait; there are trot, amble")
    arbiter.handle(PAGE, {"type": "balance", "on": False}, 0.0)
    assert not arbiter.balance
    assert (arbiter.obeyed, arbiter.refused) == (2, 1)


def test_the_oldest_message_that_waits_is_timed_and_a_moved_stick_among_them_is_not_forgotten(arbiter):
    arbiter.handle(PAGE, {**STILL, "t_ms": 1.0}, 0.0)
    assert not arbiter.pending.moved
    arbiter.handle(PAGE, {**AHEAD, "t_ms": 2.0}, 0.001)
    assert (arbiter.pending.source, arbiter.pending.t_ms, arbiter.pending.moved) == ("web", 1.0, True)
    arbiter.handle(PAGE, {**AHEAD, "t_ms": 3.0}, 0.002)
    assert (arbiter.pending.t_ms, arbiter.pending.moved) == (1.0, True)
