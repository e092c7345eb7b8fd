"""What a scan and a status leave out is said: a board that did not answer, a joint without an angle."""

import pytest

from shared.wire import names as w


@pytest.fixture
def heard(seated):
    """A robot whose joints have been heard."""
    seated.bus.listen()
    return seated


def lose_answers(walker, node, count):
    """Lose a joint's next answers to requests."""
    joint, send = walker.sim.joints[node - 1], walker.sim.nodes[node - 1].send
    left = [count]

    def lossy(identifier, data):
        if identifier == w.SERVICE_RESPONSE_ID + node and left[0]:
            left[0] -= 1
            return True
        return send(identifier, data)

    joint.send = lossy


def test_a_board_whose_answers_got_lost_is_asked_again(heard):
    lose_answers(heard, 5, 2)
    assert set(heard.bus.requests.discover()) == set(range(1, 13))


def test_a_board_that_is_there_and_never_answers_is_named(heard):
    lose_answers(heard, 5, 1000)
    boards = heard.bus.requests.discover()
    assert set(boards) == {*range(1, 13)} - {5}
    wrong = heard.bus.cycle.guard.before_arming(boards)
    assert [(notice.node, notice.what) for notice in wrong] == [(5, "mute")]
    assert "FL thigh (node 5) is there but did not report its board's number" in wrong[0].sentence


def test_a_joint_without_an_angle_says_why(run):
    code, out, _ = run("joints", "status", "--sim")
    assert code == 0
    without = [line.partition(" (")[0] for line in out.splitlines() if " - " in line]
    assert without == ["FR thigh", "FL thigh", "RR thigh", "RL thigh"]
    assert out.count("does not know its angle yet") == 4
