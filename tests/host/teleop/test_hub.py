"""Scripts on a socket and the web process's line: obeyed, refused, hung up on."""

import json
import socket
import time

import pytest

from host.errors import UserError
from host.teleop.arbiter import Client
from host.teleop.hub import MOST_SCRIPTS, Hub

from .rig import AHEAD, STOP


@pytest.fixture
def heard():
    return []


@pytest.fixture
def lost():
    return []


@pytest.fixture
def hub(tmp_path, heard, lost):
    hub = Hub(lambda client, message: heard.append((client, message)) or message["type"] != "take", lost.append)
    hub.listen(str(tmp_path / "socket"))
    yield hub
    hub.close()


def connect(tmp_path):
    stream = socket.socket(socket.AF_UNIX)
    stream.connect(str(tmp_path / "socket"))
    stream.settimeout(2)
    return stream


def say(stream, *values):
    stream.sendall(b"".join(json.dumps(value).encode() + b"\n" for value in values))


def pump(hub):
    for _ in range(30):
        hub.poll(0.002)


def test_a_script_is_heard_answered_and_missed(hub, tmp_path, heard, lost):
    stream = connect(tmp_path)
    say(stream, AHEAD, STOP, {"type": "ping", "t_ms": 3}, {"type": "take"})
    pump(hub)
    assert heard == [(Client("script", 1), message) for message in (AHEAD, STOP, {"type": "take"})]
    answers = [json.loads(line) for line in stream.recv(4096).splitlines()]
    assert [answer["type"] for answer in answers] == ["pong", "refused"]
    hub.tell({"type": "status", "state": "standing"})
    assert json.loads(stream.recv(4096))["state"] == "standing"
    stream.close()
    pump(hub)
    assert lost == [Client("script", 1)]


@pytest.mark.parametrize("line", [b"GET / HTTP/1.1\n", b"{}\n", b"x" * 5000, b'{"type": "fly"}\n', b"\xff\n"])
def test_who_sends_no_message_is_hung_up_on(hub, tmp_path, heard, lost, line):
    stream = connect(tmp_path)
    stream.sendall(line)
    pump(hub)
    assert (heard, lost, hub.scripts) == ([], [Client("script", 1)], 0)


def test_a_message_after_a_bad_line_is_not_obeyed(hub, tmp_path, heard):
    stream = connect(tmp_path)
    stream.sendall(b"nonsense\n" + json.dumps(AHEAD).encode() + b"\n")
    pump(hub)
    assert heard == []


def test_only_so_many_scripts(hub, tmp_path):
    streams = [connect(tmp_path) for _ in range(MOST_SCRIPTS)]
    pump(hub)
    streams.append(connect(tmp_path))
    pump(hub)
    assert hub.scripts == MOST_SCRIPTS
    assert streams[-1].recv(1) == b""


def test_a_script_that_does_not_read_holds_nothing_up(hub, tmp_path):
    connected = connect(tmp_path)
    pump(hub)
    began = time.monotonic()
    for _ in range(3000):
        hub.tell({"type": "status", "filling": "x" * 200})
    assert time.monotonic() - began < 5.0
    lines = next(iter(hub._scripts.values()))
    assert lines.dropped > 0
    assert len(lines._unsent) < 70_000
    connected.close()


def test_the_web_process_speaks_for_its_pages(hub, heard, lost):
    ours, theirs = socket.socketpair()
    hub.add_web(ours)
    news = []
    hub.web_news = news.append
    say(theirs, {"page": 4, "message": AHEAD}, {"page": 4, "gone": True}, {"type": "web", "pages": 1})
    say(theirs, {"page": 4, "message": {"type": "fly"}}, {"page": "x", "message": STOP}, [1], {"page": 4, "gone": True})
    pump(hub)
    assert heard == [(Client("web", 4), AHEAD)]
    assert (lost, news, hub.bad) == ([Client("web", 4)] * 2, [{"type": "web", "pages": 1}], 3)
    say(theirs, {"page": 5, "message": AHEAD})
    pump(hub)
    theirs.close()
    pump(hub)
    assert lost[-1] == Client("web", 5), "with the web process its pages are gone"


def test_a_dead_socket_is_replaced_and_a_living_one_or_a_file_is_not(tmp_path, hub):
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(tmp_path / "dead"))
    dead.close()
    (tmp_path / "file").write_text("precious")
    with Closing() as other:
        other.listen(str(tmp_path / "dead"))
    for name, why in (("socket", "another program"), ("file", "a file of that name")):
        with pytest.raises(UserError, match=why):
            Hub(lambda client, message: True, lambda client: None).listen(str(tmp_path / name))
    assert (tmp_path / "file").read_text() == "precious"


class Closing(Hub):
    """A hub that closes with its block."""

    def __init__(self):
        super().__init__(lambda client, message: True, lambda client: None)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
