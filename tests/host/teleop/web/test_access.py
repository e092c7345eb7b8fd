"""Names, origins, pairing codes, rate limits, and what the page draws."""

import os
import socket
from math import radians

import pytest

from host.robot.file import load_robot
from host.robot.poses import rest_pose_rad
from host.robot.view import View
from host.teleop.side import listen_address
from host.teleop.web.access import BETWEEN_S, GUESSES, LONGEST_REST_S, REST_S, Names, Pairing, is_loopback, new_code
from host.teleop.web.door import listen
from host.teleop.web.limits import MOST_PEERS, Bucket, PerPeer
from host.teleop.web.peer import may_open_sockets, peer_of
from host.util.errors import UserError


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
    pairing = Pairing("123456", {"user 1000"}, clock)
    assert not pairing.allows(None, "10.0.0.2")
    assert not pairing.allows("guess", "10.0.0.2")
    token = pairing.pair("123456", "10.0.0.2")
    assert pairing.allows(token, "10.0.0.2")
    assert pairing.allows(None, "user 1000")
    assert not pairing.allows(None, "user 1001")
    assert len(new_code()) == 6


def test_guessing_is_slow_and_gets_slower():
    clock = Clock()
    pairing = Pairing("123456", (), clock)
    for rest_s in (REST_S, 2 * REST_S, 4 * REST_S):
        for guess in range(GUESSES):
            assert pairing.pair("000000", "10.0.0.2") is None
            assert pairing.pair("123456", "10.0.0.2") is None, "the right one too soon after a wrong one"
            clock.now_s += BETWEEN_S if guess < GUESSES - 1 else rest_s - BETWEEN_S
        assert pairing.pair("123456", "10.0.0.2") is None
        clock.now_s += BETWEEN_S
    assert pairing.pair("123456", "10.0.0.2") is not None


def test_a_strangers_guesses_lock_out_the_stranger_only():
    clock = Clock()
    pairing = Pairing("123456", (), clock)
    for _ in range(500):
        pairing.pair("000000", "10.0.0.66")
        clock.now_s += BETWEEN_S
    assert pairing.pair("123456", "10.0.0.66") is None
    assert pairing.pair("123456", "10.0.0.2") is not None
    clock.now_s += LONGEST_REST_S
    assert pairing.pair("123456", "10.0.0.66") is not None, "nobody is locked out for good"


@pytest.mark.parametrize("code", ["١٢٣٤٥٦", "\udcff", ""])
def test_a_code_that_is_no_ascii_is_only_wrong(code):
    pairing = Pairing("123456", (), Clock())
    assert pairing.pair(code, "10.0.0.2") is None
    assert not pairing.allows(code, "10.0.0.2")


def test_only_so_many_peers_are_remembered():
    kept = PerPeer(list)
    kept["first"].append(1)
    for number in range(MOST_PEERS - 1):
        kept[str(number)]
    assert kept["first"] == [1]
    kept["one more"]
    assert (len(kept._kept), kept["first"], kept["0"]) == (MOST_PEERS, [1], [])


@pytest.mark.parametrize(
    ("address", "peer"),
    [
        ("192.168.1.5", "192.168.1.5"),
        ("::ffff:192.168.1.5", "192.168.1.5"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("?", "unknown"),
    ],
)
def test_peers_elsewhere(address, peer):
    class Stream:
        def getpeername(self):
            return address, 40000

        def getsockname(self):
            return "192.168.1.1", 8080

    assert peer_of(Stream()) == peer


@pytest.mark.parametrize(("address", "family"), [("127.0.0.1", socket.AF_INET), ("::1", socket.AF_INET6)])
def test_a_peer_on_this_machine_is_a_user(address, family):
    with listen(address, 0) as listener, socket.socket(family) as ours:
        ours.connect(listener.getsockname())
        theirs, _ = listener.accept()
        with theirs:
            assert peer_of(theirs) == f"user {os.getuid()}"
            assert peer_of(theirs) in may_open_sockets()


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
    rest = rest_pose_rad(robot)
    seen = View(robot).points(rest, 0.0, 0.0, 0b1001)
    for leg in range(4):
        hip, _, knee, foot = seen["legs"][leg]
        assert foot[2] == pytest.approx(-robot.stance.rest_height_m, abs=2e-4)
        assert hip == pytest.approx([*robot.hip_m(leg), 0.0], abs=1e-4)
        assert (knee[0] < hip[0]) == (robot.knee_sign(leg) < 0)
    assert seen["standing"] == [1, 2]
    assert abs(seen["com"][1]) < 1e-3
    assert -robot.stance.rest_height_m < seen["com"][2] < 0.02


def test_nothing_is_drawn_below_the_ground():
    robot = load_robot("caramelo")
    rest = rest_pose_rad(robot)
    assert View(robot).points(rest, 0.0, 0.0, 0)["ground_m"] == pytest.approx(-robot.stance.rest_height_m, abs=2e-4)
    folded = [value for leg in range(4) for value in (0.0, 0.0, robot.knee_sign(leg) * radians(150))]
    seen = View(robot).points(folded, 0.0, 0.0, 0)
    knees, feet = ([leg[part][2] for leg in seen["legs"]] for part in (2, 3))
    assert min(knees) < min(feet), "it lies on its knees"
    assert seen["ground_m"] == min(knees)


def test_the_view_turns_with_the_attitude():
    robot = load_robot("caramelo")
    rest = rest_pose_rad(robot)
    nose_down = View(robot).points(rest, 0.0, radians(10), 0)
    assert nose_down["legs"][0][0][2] < 0 < nose_down["legs"][2][0][2]
    left_up = View(robot).points(rest, radians(10), 0.0, 0)
    assert left_up["legs"][0][0][2] < 0 < left_up["legs"][1][0][2]
