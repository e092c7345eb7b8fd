"""What viewers may say: refused before pairing, bounded, checked like every other client's messages."""

import json

import pytest

from host.teleop.foxglove.viewers import COMMAND, SPEED, Viewers
from host.teleop.web.access import GUESSES, REST_S
from host.teleop.web.limits import BURST
from tests.host.control.rig import AHEAD, STOP

CODE = "271828"
PAIR = {"type": "pair", "code": CODE}


class House:
    def __init__(self):
        self.now_s, self.heard, self.told = 0.0, [], []
        self.viewers = Viewers(CODE, self.heard.append, self.told.append, lambda: self.now_s)

    def say(self, value, topic=COMMAND, number=1):
        self.viewers.take(number, topic, value if isinstance(value, bytes) else json.dumps(value).encode())


@pytest.fixture
def house():
    return House()


def test_before_pairing_nothing_counts_not_even_a_stop(house):
    house.say(AHEAD)
    house.say(STOP)
    assert (house.heard, house.viewers.refused) == ([], 2)
    house.say(PAIR)
    house.say(AHEAD)
    assert house.heard == [{"page": 1, "message": AHEAD}]
    house.say(AHEAD, number=2)
    assert len(house.heard) == 1, "each connection pairs by itself"


def test_guesses_of_all_viewers_are_one_count(house):
    for number in range(GUESSES):
        house.say({"type": "pair", "code": "000000"}, number=number)
        house.now_s += 1.5
    house.say(PAIR, number=99)
    house.say(AHEAD, number=99)
    assert house.heard == []
    house.now_s += REST_S
    house.say(PAIR, number=99)
    house.say(AHEAD, number=99)
    assert len(house.heard) == 1


def test_a_twist_is_the_sticks(house):
    house.say(PAIR)
    house.say({"linear": {"x": 0.1, "y": -0.05, "z": 9}, "angular": {"x": 0, "y": 0, "z": 0.3}}, SPEED)
    sticks = house.heard[0]["message"]
    assert (sticks["vx_m_s"], sticks["vy_m_s"], sticks["wz_rad_s"], sticks["pose"]) == (0.1, -0.05, 0.3, [0.0] * 6)


@pytest.mark.parametrize(
    ("topic", "data"),
    [
        (COMMAND, b"no json"),
        (COMMAND, b"[1]"),
        (COMMAND, b'{"type": "fly"}'),
        (COMMAND, b'{"type": "pair"}'),
        (COMMAND, b'{"type": "pair", "code": 1}'),
        (COMMAND, b'{"type": "stop", "x": "' + b"x" * 600 + b'"}'),
        (SPEED, b'{"linear": 1, "angular": 2}'),
        (SPEED, b'{"linear": {"x": NaN, "y": 0}, "angular": {"z": 0}}'),
        (SPEED, b'{"linear": {"x": 99, "y": 0}, "angular": {"z": 0}}'),
        (SPEED, b'{"linear": {"x": "1", "y": 0}, "angular": {"z": 0}}'),
        ("/other", b"{}"),
        (COMMAND, b"[" * 500),
    ],
)
def test_what_is_no_message_is_counted_and_told(house, topic, data):
    house.say(PAIR)
    house.say(data, topic)
    assert (house.heard, house.viewers.malformed) == ([], 1)
    assert topic in house.told[-1]


def test_too_many_are_left_out_but_for_stops(house):
    house.say(PAIR)
    for _ in range(2 * BURST):
        house.say(AHEAD)
    house.say(STOP)
    assert len(house.heard) == BURST
    assert house.heard[-1]["message"] == STOP
    assert house.viewers.limited == BURST + 1


def test_one_that_leaves_is_gone_for_the_loop_and_must_pair_again(house):
    house.say(PAIR)
    house.viewers.leave(1)
    assert house.heard == [{"page": 1, "gone": True}]
    house.say(AHEAD)
    assert len(house.heard) == 1
