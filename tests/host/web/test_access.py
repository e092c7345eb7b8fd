"""Names, origins, pairing codes, rate limits, and what the page draws."""

from math import radians

import pytest

from host.errors import UserError
from host.plane import rest_pose_rad
from host.robot_file import load_robot
from host.teleop.webside import listen_address
from host.web.access import BETWEEN_S, GUESSES, REST_S, Names, Pairing, is_loopback, new_code
from host.web.limits import Bucket
from host.web.view import View


class Clock:
    now_s = 0.0

    def __call__(self):
        return self.now_s


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "LOCALHOST:8080"])
def test_names_of_this_machine(host):
    names = Names("127.0.0.1", 8080)
    assert names.host_ok(host)
    assert names.origin_ok(f"http://{host}", host)


@pytest.mark.parametrize(
    "host", ["evil.example:8080", "127.0.0.1:8081", "127.0.0.1", "192.168.1.5:8080", "", None, "a:b:c", "[::1:8080"]
)
def test_foreign_names_are_refused(host):
    assert not Names("127.0.0.1", 8080).host_ok(host)


def test_an_open_listener_takes_addresses_and_its_own_name():
    names = Names("0.0.0.0", 80)
    assert names.host_ok("192.168.1.5")
    assert names.host_ok("192.168.1.5:80")
    assert not names.host_ok("evil.example")


@pytest.mark.parametrize("origin", [None, "null", "http://evil.example", "https://127.0.0.1:8080", "http://127.0.0.1"])
def test_foreign_origins_are_refused(origin):
    assert not Names("127.0.0.1", 8080).origin_ok(origin, "127.0.0.1:8080")


def test_loopback():
    assert is_loopback("127.0.0.1")
    assert is_loopback("::1")
    assert is_loopback("localhost")
    assert not is_loopback("0.0.0.0")
    assert not is_loopback("robot.local")


def test_pairing():
    clock = Clock()
    pairing = Pairing("123456", clock)
    assert not pairing.allows(None)
    assert not pairing.allows("guess")
    token = pairing.pair("123456")
    assert pairing.allows(token)
    assert Pairing("", clock).allows(None)
    assert len(new_code()) == 6


def test_guessing_is_slow():
    clock = Clock()
    pairing = Pairing("123456", clock)
    for _ in range(GUESSES):
        assert pairing.pair("000000") is None
        assert pairing.pair("123456") is None, "the right one too soon after a wrong one"
        clock.now_s += BETWEEN_S
    assert pairing.pair("123456") is None
    clock.now_s += REST_S
    assert pairing.pair("123456") is not None


def test_a_code_that_is_no_ascii_is_only_wrong():
    assert Pairing("123456", Clock()).pair("١٢٣٤٥٦") is None


def test_bucket():
    clock = Clock()
    bucket = Bucket(10.0, 3, clock)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    clock.now_s = 0.1
    assert [bucket.take() for _ in range(2)] == [True, False]
    clock.now_s = 100.0
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("127.0.0.1", ("127.0.0.1", 8080)),
        ("0.0.0.0:80", ("0.0.0.0", 80)),
        ("[::]:90", ("::", 90)),
        ("[::1]", ("::1", 8080)),
        ("::", ("::", 8080)),
    ],
)
def test_listen_addresses(text, where):
    assert listen_address(text) == where


@pytest.mark.parametrize("text", ["", ":80", "a:0", "a:70000", "a:b", "[]:80"])
def test_wrong_listen_addresses(text):
    with pytest.raises(UserError, match="--listen"):
        listen_address(text)


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_view_of_a_standing_robot(name):
    robot = load_robot(name)
    rest = [angle for leg in range(4) for angle in rest_pose_rad(robot, leg)]
    seen = View(robot).points(rest, 0.0, 0.0, 0b1001)
    for leg in range(4):
        hip, _, knee, foot = seen["legs"][leg]
        assert foot[2] == pytest.approx(-robot.stance.rest_height_m, abs=2e-4)
        assert hip == pytest.approx([*robot.hip_m(leg), 0.0], abs=1e-4)
        assert (knee[0] < hip[0]) == (robot.knee_sign(leg) < 0)
    assert seen["standing"] == [1, 2]
    assert abs(seen["com"][1]) < 1e-3
    assert -robot.stance.rest_height_m < seen["com"][2] < 0.02


def test_the_view_turns_with_the_attitude():
    robot = load_robot("caramelo")
    rest = [angle for leg in range(4) for angle in rest_pose_rad(robot, leg)]
    nose_down = View(robot).points(rest, 0.0, radians(10), 0)
    assert nose_down["legs"][0][0][2] < 0 < nose_down["legs"][2][0][2]
    left_up = View(robot).points(rest, radians(10), 0.0, 0)
    assert left_up["legs"][0][0][2] < 0 < left_up["legs"][1][0][2]
