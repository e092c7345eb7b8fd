"""Answers that come late are counted once: as lost when they are given up, and not again when they come."""

import pytest
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS

from host.bus.dynamixel import table as t
from host.bus.dynamixel.link import Link


class Port:
    """A port that nobody reads."""

    is_real = False
    patience_ms = 0.0

    def clearPort(self):
        """Clear nothing."""


class Line(Link):
    """A link whose answers the test lays out: (servo, bytes), or None where the waiting ends."""

    def __init__(self):
        super().__init__(Port(), 1.0)
        self.coming = []

    def _receive(self):
        answer = self.coming.pop(0)
        if answer is None:
            return [], COMM_RX_TIMEOUT
        servo, size = answer
        return [255, 255, servo, 2 + size, 0, *[0] * size, 0], COMM_SUCCESS

    def exchange(self, wanted, length, *coming):
        self.coming = list(coming)
        return len(self._collect(wanted, (0, length)))


def test_a_late_answer_is_one_error():
    line = Line()
    assert line.exchange([1, 2, 3], 6, (1, 6), None) == 1
    assert line.exchange([4], 2, (2, 6), (3, 6), (4, 2)) == 1
    counters = line.counters
    assert (counters.lost, counters.late, counters.wrong, counters.errors) == (2, 2, 0, 2)


def test_an_answer_that_nobody_was_asked_for_is_an_error():
    line = Line()
    assert line.exchange([1], 6, (9, 6), (1, 6)) == 1
    assert (line.counters.late, line.counters.wrong, line.counters.errors) == (0, 1, 1)


def test_an_answer_is_not_late_once_all_have_come():
    line = Line()
    line.exchange([1, 2], 6, (1, 6), None)
    assert line.exchange([1, 2], 6, (1, 6), (2, 6)) == 2
    line.exchange([1], 6, (9, 6), (1, 6))
    assert (line.counters.late, line.counters.wrong) == (0, 1)


@pytest.mark.parametrize(("late_ms", "model"), [(0.0, 30), (100.0, 30), (1000.0, None)])
def test_a_servo_that_is_late_is_asked_again_with_more_patience(monkeypatch, late_ms, model):
    link = Link(Port())

    def slow(port, servo):
        return (30, COMM_SUCCESS, 0) if port.patience_ms >= late_ms else (0, COMM_RX_TIMEOUT, 0)

    monkeypatch.setattr(link.packets, "ping", slow)
    assert (link.ping(3), link.ping(3, tries=1)) == (model, None if late_ms else 30)
    assert link.port.patience_ms == 0.0


class Dozing:
    """A servo that sleeps through its first question, and answers all it was asked together with the second.

    What is on its way then comes to the next question, unless somebody waits for it and clears the line.
    """

    def __init__(self, link, monkeypatch):
        self.asked, self.coming, self.here = [], [], 0
        monkeypatch.setattr(link.packets, "readTxRx", self.read)
        monkeypatch.setattr("host.bus.dynamixel.link.time.sleep", self.sleep)
        monkeypatch.setattr(link.port, "clearPort", self.clear)

    def read(self, port, servo, address, size):
        self.asked.append(address)
        if len(self.asked) == 1:
            return [], COMM_RX_TIMEOUT, 0
        self.coming += self.asked if len(self.asked) == 2 else self.asked[-1:]
        return [self.coming.pop(0), 0], COMM_SUCCESS, 0

    def sleep(self, seconds):
        self.here = len(self.coming)

    def clear(self):
        del self.coming[: self.here]


def test_an_answer_to_a_question_that_was_asked_again_is_not_taken_for_the_next_ones(monkeypatch):
    """On a busy machine emulated servos reported 0 V: what came was the load, which has as many bytes."""
    link = Link(Port())
    Dozing(link, monkeypatch)
    assert link.read(1, t.PRESENT_LOAD) == t.PRESENT_LOAD.address
    assert link.read(1, t.PRESENT_VOLTAGE) == t.PRESENT_VOLTAGE.address
