"""Scripts on a socket and the web process's line: obeyed, refused, hung up on."""

import json
import os
import socket
import time
from contextlib import ExitStack, closing

import pytest

from host.control.arbiter import Client
from host.control.messages import parse
from host.lab.teleop.watched import free_port
from host.teleop.hub import BURST, CONNECTION_BURST, MOST_SCRIPTS, PATIENCE, Hub
from host.util.errors import UserError
from tests.host.control.rig import AHEAD, RESET, STOP, Rig


@pytest.fixture
def heard():
    return []


@pytest.fixture
def lost():
    return []


@pytest.fixture
def listen(tmp_path, heard, lost):
    """Return a function that makes a hub listen, on the folder's socket unless told otherwise."""

    def receive(client, message):
        heard.append((client, message))
        return message["type"] != "take"

    def listen(where=tmp_path / "socket", **options):
        hub = hubs.enter_context(closing(Hub(receive, lost.append, **options)))
        hub.listen(str(where))
        return hub

    with ExitStack() as hubs:
        yield listen


@pytest.fixture
def hub(listen):
    return listen()


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
    say(stream, STOP, AHEAD, {"type": "ping", "t_ms": 3}, {"type": "take"})
    pump(hub)
    assert heard == [(Client("script", 1), message) for message in (STOP, AHEAD, {"type": "take"})]
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
    lines = next(iter(hub._scripts.values())).lines
    assert lines.dropped > 0
    assert len(lines._unsent) < 70_000
    connected.close()


def flood(stream, messages):
    """Send until all is sent or the other side hangs up."""
    data = (json.dumps({"type": "take"}).encode() + b"\n") * messages
    stream.setblocking(False)
    try:
        return stream.send(data)
    except (BlockingIOError, BrokenPipeError, ConnectionResetError):
        return 0


def test_scripts_that_flood_are_hung_up_on_and_hardly_looked_at(listen, tmp_path, monkeypatch, lost):
    parsed = []
    monkeypatch.setattr("host.teleop.hub.parse", lambda line, keys: parsed.append(line) or parse(line, keys))
    hub = listen(clock=lambda: 0.0)
    streams = [connect(tmp_path) for _ in range(3)]
    for _ in range(3000):
        for stream in streams:
            flood(stream, 100)
        hub.poll(0.0)
        if hub.scripts == 0 and lost:
            break
    assert len(lost) == 3
    assert len(parsed) == 3 * BURST
    assert hub.limited == 3 * PATIENCE
    assert b"more than 200 messages a second" in streams[0].recv(1 << 20).splitlines()[-1]


def test_a_stop_is_heard_in_a_flood(listen, tmp_path, heard, lost):
    hub = listen(clock=lambda: 0.0)
    stream = connect(tmp_path)
    say(stream, *[{"type": "take"}] * (BURST + PATIENCE // 2), STOP)
    for _ in range(100):
        hub.poll(0.01)
        if heard and heard[-1][1] == STOP:
            break
    assert [message["type"] for _, message in heard] == ["take"] * BURST + ["stop"]
    assert lost == []


def test_who_connects_again_and_again_is_let_in_only_so_often(listen, tmp_path):
    hub = listen(clock=lambda: 0.0)
    for _ in range(2 * CONNECTION_BURST):
        with connect(tmp_path):
            hub.poll(1.0)
        hub.poll(0.0)
    assert hub._number == CONNECTION_BURST


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody else")
def test_a_port_is_only_for_who_could_open_the_sockets_file(listen):
    port = free_port()
    hub = listen(port)
    os.seteuid(65534)  # a socket belongs to the user who makes it
    try:
        stranger = socket.socket()
    finally:
        os.seteuid(0)
    stranger.connect(("127.0.0.1", port))
    with stranger, socket.create_connection(("127.0.0.1", port)):
        pump(hub)
        assert stranger.recv(1) == b""
        assert hub.scripts == 1


def test_the_web_process_speaks_for_its_pages(hub, heard, lost):
    ours, theirs = socket.socketpair()
    news = []
    hub.add_side("web", ours, news.append)
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


def test_a_dead_socket_is_replaced_and_a_living_one_or_a_file_is_not(tmp_path, hub, listen):
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(tmp_path / "dead"))
    dead.close()
    (tmp_path / "file").write_text("precious")
    listen(tmp_path / "dead")
    for name, why in (("socket", "another program"), ("file", "a file of that name")):
        with pytest.raises(UserError, match=why):
            listen(tmp_path / name)
    assert (tmp_path / "file").read_text() == "precious"


def test_a_stop_overtakes_what_its_sender_said_before(hub, tmp_path, heard):
    script = connect(tmp_path)
    pump(hub)
    say(script, *[RESET] * 50, AHEAD, STOP, RESET, AHEAD)
    pump(hub)
    assert [message["type"] for _, message in heard] == ["stop", "reset", "drive"], (
        "and what came after it stays after it"
    )


def test_a_stop_before_hanging_up_is_heard(hub, tmp_path, heard, lost):
    script = connect(tmp_path)
    pump(hub)
    script.sendall(json.dumps(STOP).encode() + b"\n" + b"x" * 600)
    pump(hub)
    assert [message["type"] for _, message in heard] == ["stop"]
    assert len(lost) == 1


def test_the_figure_of_a_stop_counts_from_when_its_source_was_last_quiet(tmp_path):
    """The loop was away for 0.4 s while the stop waited; looking at it did not make it younger."""
    rig = Rig()
    hub = Hub(rig.loop.receive, rig.loop.drop, rig.clock)
    hub.listen(str(tmp_path / "socket"))
    script = connect(tmp_path)
    hub.poll(1.0)
    rig.loop.tick(hub)
    say(script, STOP)
    rig.now_s += 0.4
    rig.loop.tick(hub)
    assert rig.arbiter.stop is not None
    assert list(rig.loop.stop_s["script"]) == pytest.approx([0.4])
    hub.close()
    script.close()
