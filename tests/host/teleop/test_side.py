"""The page's process: watched, started again, and the robot that it leaves alone sits down."""

import os
import signal
import socket
import urllib.request

import pytest

from host.lab.teleop.watched import free_port
from host.teleop.hub import Hub
from host.teleop.side import AGAIN_S, PAGE, SILENT_S, STEADY_S, UNREACHABLE_S, SideProcess
from host.util.errors import UserError
from tests.host.control.rig import SCRIPT, STILL, Rig
from tests.waiting import PATIENCE_S, wait_until

CODE = "314159"
TURN_S = 0.02
SETUP = {"robot": "caramelo", "code": CODE, "about": {"robot": "caramelo"}, "counts_s": 0.05}


class Side:
    """The loop's side of a page on a clock that runs with its turns, and that the test may move on."""

    def __init__(self):
        self.time_s = 0.0
        self.rig = Rig()
        self.port = free_port()
        self.hub = Hub(self.rig.loop.receive, self.rig.loop.drop)
        self.web = SideProcess(PAGE, ("127.0.0.1", self.port), SETUP, lambda: self.time_s)
        self.web.start(self.hub)
        self.web.wait(self.hub)

    def turn(self):
        """What the loop does, a few ticks long."""
        self.time_s += TURN_S
        self.hub.poll(TURN_S)
        self.web.watch(self.hub, self.rig.supervisor)

    def until(self, found):
        """Turn until it is found."""
        wait_until(lambda: found() or self.turn(), lambda: self.web.note, every_s=0.0)

    def kill(self):
        """End the process and wait until that is seen."""
        os.kill(self.web.process.pid, signal.SIGKILL)
        self.until(lambda: self.web.note.startswith("no page"))

    def close(self):
        self.hub.close()
        self.web.close()


@pytest.fixture
def side():
    side = Side()
    yield side
    side.close()


def served(port):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=PATIENCE_S) as answer:
        return answer.status


def test_a_page_whose_process_was_killed_is_served_again(side):
    first = side.web.process.pid
    assert side.web.note == f"http://127.0.0.1:{side.port}"
    side.kill()
    assert side.web.note == "no page: ended by signal 9; start 2 follows"
    side.until(lambda: side.web.note.startswith("http"))
    assert side.web.process.pid != first
    assert served(side.port) == 200


def test_the_code_is_told_by_nothing_it_says(side):
    side.until(lambda: side.web.counts.refusals)
    assert CODE not in side.web.note + str(side.web.counts)


def test_a_process_that_stands_still_is_replaced(side):
    os.kill(side.web.process.pid, signal.SIGSTOP)
    side.turn()
    side.time_s += SILENT_S + 0.5
    side.turn()
    assert side.web.note.startswith("no page: the page's process has reported nothing for ")
    side.until(lambda: side.web.note.startswith("http"))
    assert served(side.port) == 200


def test_a_robot_that_stands_alone_without_a_page_sits_down(side):
    rig = side.rig
    rig.stand()
    rig.run(5.0)
    assert (rig.arbiter.driver, rig.supervisor.armed) == (None, True)
    side.kill()
    with socket.create_server(("127.0.0.1", side.port)):  # so that it can't come back
        side.time_s += UNREACHABLE_S / 2
        side.turn()
        assert rig.supervisor.safety.first is None, "there is still time to come back"
        side.time_s += UNREACHABLE_S / 2
        side.turn()
        assert rig.supervisor.safety.first.cause == "page"
        assert "out of reach" in rig.supervisor.safety.sentence
        rig.run(6.0)
        assert not rig.supervisor.armed
        side.until(lambda: "Address already in use" in side.web.note or "address already in use" in side.web.note)


def test_somebody_else_who_drives_goes_on_without_the_page(side):
    rig = side.rig
    rig.stand()
    side.kill()
    rig.run(0.2, STILL, SCRIPT)
    side.time_s += 2 * UNREACHABLE_S
    side.turn()
    assert rig.supervisor.safety.first is None


def test_a_page_that_is_back_in_time_is_forgiven(side):
    side.rig.stand()
    side.rig.run(5.0)
    side.kill()
    side.time_s += AGAIN_S
    side.until(lambda: side.web.note.startswith("http"))
    ends_s, starts = side.time_s + UNREACHABLE_S + STEADY_S, side.web.starts
    while side.time_s < ends_s:
        heard_s = side.web._heard_s
        side.until(lambda heard_s=heard_s: side.web._heard_s > heard_s)
        side.time_s += SILENT_S - 2.0  # it speaks sooner
    assert side.web.starts == starts
    assert side.rig.supervisor.safety.first is None


def test_a_page_that_never_steadies_is_not_forgiven(side):
    side.rig.stand()
    side.rig.run(5.0)
    while side.rig.supervisor.safety.first is None:
        side.kill()
        side.time_s += UNREACHABLE_S / 4
        side.until(lambda: side.web.note.startswith("http") or side.rig.supervisor.safety.first)
        assert side.web.starts < 20
    assert side.rig.supervisor.safety.first.cause == "page"


def test_the_joints_are_read_while_the_page_starts():
    rig, hub = Rig(), Hub(lambda client, message: True, lambda client: None)
    web = SideProcess(PAGE, ("127.0.0.1", free_port()), SETUP)
    web.start(hub)
    asked = rig.bus.counters.sent
    web.wait(hub, rig.supervisor.sense)
    assert rig.bus.counters.sent > asked
    hub.close()
    web.close()


def test_why_it_can_not_start_is_told():
    hub = Hub(lambda client, message: True, lambda client: None)
    web = SideProcess(PAGE, ("127.0.0.1", free_port()), {**SETUP, "robot": "no such robot"})
    web.start(hub)
    with pytest.raises(UserError, match=r"did not start: .*no such robot"):
        web.wait(hub)
    hub.close()
