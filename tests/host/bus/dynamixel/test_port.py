"""The real port code on a pseudo-terminal: emulated servos in their own process, and what goes wrong with ports."""

import errno
import itertools
import os
import pty
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest
import serial

from host.bus.dynamixel import link as link_module
from host.bus.dynamixel import table as t
from host.bus.dynamixel import tools
from host.bus.dynamixel.bus import ServoBus
from host.bus.dynamixel.calibration.data import nominal
from host.bus.dynamixel.link import PING_PATIENCE_MS, Link
from host.bus.dynamixel.port import PATIENCE_MS, ServoPort, explain, latency_ms, latency_warning
from host.commands._hardware import hardware
from host.sim.servos.packets import framing
from host.sim.servos.process import Emulator
from host.util.errors import UserError
from tests import ROOT
from tests.processes import child_of
from tests.waiting import PATIENCE_S, wait_until

from .rig import CARAMELO, PERIOD_S

BAUD = CARAMELO.bus.baud


@pytest.fixture
def emulator():
    with Emulator("--plant", "bench") as running:
        yield running


@pytest.fixture
def open_port(emulator):
    """An open port to the emulated servos."""
    port = ServoPort(emulator.port, BAUD)
    port.open()
    yield port
    port.closePort()


def furthest(one, other):
    """Return how far two poses differ at most, rad."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def cycle_until(cycle, enough):
    """Do a control cycle every period until what it returns is enough; return that."""
    last = []

    def once():
        last[:] = [cycle()]
        return enough(last[0])

    wait_until(once, lambda: last, every_s=PERIOD_S)
    return last[0]


def test_the_sdk_talks_through_a_terminal(emulator):
    with ServoBus(CARAMELO, nominal(CARAMELO), ServoPort(emulator.port, BAUD)) as bus:
        measured = cycle_until(bus.read, lambda measured: measured.complete)
        bus.torque(True)
        goals = [angle + 0.1 for angle in measured.position_rad]

        def cycle():
            bus.write(goals)
            seen, state = bus.read().position_rad, emulator.ask("state")
            if -1 in state["watchdog"]:  # this machine was so busy that the servos stopped themselves
                bus.torque(True)
            return seen, state

        def there(seen, state):
            return furthest(goals, state["position_rad"]) < 0.03 and furthest(seen, state["position_rad"]) < 0.01

        cycle_until(cycle, lambda found: there(*found) and all(found[1]["follows"]))
        assert bus.counters.answered > 0.5 * bus.counters.sent
    assert not any(emulator.ask("state")["torque"])


def test_real_time_walking_with_a_bad_line_and_a_trip():
    with hardware(CARAMELO, "emulated") as parts, parts.bus as bus:
        emulator = parts.attitude.source.emulator
        emulator.ask("disturb", lost=0.01, corrupted=0.01)
        bus.torque(True)
        cycle_until(lambda: bus.write(bus.read().position_rad), lambda _: bus.counters.lost and bus.counters.corrupted)
        emulator.ask("trip", servo=5)
        cycle_until(bus.read, lambda measured: measured.error[4] == "overload")  # at first it may be the watchdog
        parts.attitude.open()
        cycle_until(parts.attitude.update, lambda angles: angles is not None)
        assert parts.attitude.state == "ok", parts.attitude.note


CHILD = """
import sys, time
from host.bus.dynamixel.calibration.data import nominal
from host.robot.file import load_robot
from host.bus.dynamixel.bus import ServoBus
from host.bus.dynamixel.port import ServoPort
robot = load_robot("caramelo")
bus = ServoBus(robot, nominal(robot), ServoPort(sys.argv[1], robot.bus.baud))
bus.open()
bus.torque(True)
print("on", flush=True)
while True:
    bus.write(bus.read().position_rad)
    time.sleep(0.02)
"""


@contextmanager
def holder(emulator):
    """Yield a program that holds the servos; it is killed at the end."""
    child = subprocess.Popen([sys.executable, "-c", CHILD, emulator.port], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "on\n"
        wait_until(lambda: all(emulator.ask("state")["torque"]), "all servos hold")
        yield child
    finally:
        child.kill()
        child.wait(PATIENCE_S)
        child.stdout.close()


@pytest.mark.parametrize("death", [signal.SIGKILL, signal.SIGSTOP, signal.SIGSEGV])
def test_whoever_holds_the_servos_dies_or_hangs_and_they_are_let_go(emulator, death):
    """The servos' own watchdog only stops them; the guardian takes the torque away."""
    with holder(emulator) as child:
        child.send_signal(death)
        wait_until(lambda: not any(emulator.ask("state")["torque"]), "all servos are let go")


def test_the_servos_own_watchdog_stops_them_and_they_go_on_holding(emulator):
    """With the guardian dead too nobody lets go: a switch has to."""
    with holder(emulator) as child:
        guardian = child_of(child.pid, "host.bus.dynamixel.guardian")
        for process in (guardian, child.pid):  # in this order: it lets go as soon as it misses the child
            os.kill(process, signal.SIGSTOP)
        # Each does so within WATCHDOG_S by its own clock (test_bus.py); here a busy machine may be late.
        wait_until(lambda: not any(emulator.ask("state")["follows"]), "the servos stop themselves")
        state = emulator.ask("state")
        assert state["watchdog"] == [-1] * 12
        assert state["torque"] == [True] * 12
        os.kill(guardian, signal.SIGCONT)
        wait_until(lambda: not any(emulator.ask("state")["torque"]), "all servos are let go")


def test_a_guardian_that_dies_is_a_fault_and_closing_ends_it(emulator):
    with ServoBus(CARAMELO, nominal(CARAMELO), ServoPort(emulator.port, BAUD)) as bus:
        guardian = bus._guardian.process
        assert bus.read().faults == ()
        guardian.kill()
        guardian.wait(PATIENCE_S)
        bus.torque(True)
        wait_until(lambda: [fault.cause for fault in bus.read().faults] == ["guardian"], "the guardian is missed")
    with ServoBus(CARAMELO, nominal(CARAMELO), ServoPort(emulator.port, BAUD)) as bus:
        bus.torque(True)
        guardian = bus._guardian.process
    assert guardian.wait(PATIENCE_S) == 0
    assert not any(emulator.ask("state")["torque"])


def test_wrong_rate_gets_no_answer(emulator):
    with pytest.raises(UserError, match="no servo answers at 57600 baud"):
        ServoBus(CARAMELO, nominal(CARAMELO), ServoPort(emulator.port, 57600)).open()


def test_a_port_in_use_is_told(emulator, open_port):
    with pytest.raises(UserError, match="another program uses it"):
        ServoPort(emulator.port, BAUD).open()
    open_port.closePort()
    ServoPort(emulator.port, BAUD).open()


def test_no_such_port_is_told():
    with pytest.raises(UserError, match=r"no such port; serial ports here: .*; name yours with --port"):
        ServoPort("/dev/ttyUSB97", BAUD).open()


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.EACCES, "usermod -aG dialout"),
        (errno.EBUSY, "another program uses it"),
        (errno.ENOTTY, "check that it is a serial port"),
    ],
)
def test_other_reasons_are_told(number, words):
    assert words in explain("/dev/ttyUSB0", serial.SerialException(number, os.strerror(number)))


def test_an_adapter_that_goes_away_is_one_sentence():
    ours, theirs = pty.openpty()
    port = ServoPort(os.ttyname(theirs), BAUD)
    port.open()
    os.close(theirs)
    os.close(ours)
    with pytest.raises(UserError, match="the adapter is gone"):
        Link(port).read_all([1], (126, 10))
    bus = ServoBus(CARAMELO, nominal(CARAMELO), port)
    bus._opened = True
    bus.close()
    assert "the adapter is gone" in bus.warnings[0]


def test_a_slow_adapter_is_warned_about_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.setattr("host.bus.dynamixel.port.LATENCY_TIMER", str(tmp_path / "{tty}" / "latency_timer"))
    timer = tmp_path / "ttyUSB0" / "latency_timer"
    assert latency_ms("/dev/ttyUSB0") is None
    assert latency_warning("/dev/ttyUSB0") is None
    timer.parent.mkdir()
    timer.write_text("16\n")
    warning = latency_warning("/dev/ttyUSB0")
    assert warning == f"/dev/ttyUSB0: the adapter delays answers by 16 ms; run: echo 1 | sudo tee {timer}"
    timer.write_text("1\n")
    assert latency_warning("/dev/ttyUSB0") is None


def test_a_lost_answer_costs_little_time(silent_port):
    """Less than the SDK's own 34 ms, which is almost two control periods, by far."""
    port = ServoPort(silent_port, BAUD)
    port.open()
    took_s = []
    for _ in range(5):
        began_s = time.monotonic()
        assert Link(port).read_all([1], (126, 10)) == {}
        took_s.append(time.monotonic() - began_s)
    assert min(took_s) < 0.034


def test_renumbering_and_rates(open_port):
    link = Link(open_port)
    tools.set_id(link, 3, 40)
    assert link.ping(40) is not None
    assert link.ping(3) is None
    for old, new, words in ((3, 5, "no servo answers with id 3"), (40, 5, "id 5 is taken"), (40, 300, "0 .. 252")):
        with pytest.raises(UserError, match=words):
            tools.set_id(link, old, new)
    tools.set_baud(link, 40, 1_000_000)
    assert open_port.getBaudRate() == 1_000_000
    assert [found.id for found in tools.find(link)] == [40]
    with pytest.raises(UserError, match="allowed 9600"):
        tools.set_baud(link, 40, 123)


def test_an_adapter_that_takes_no_bytes_loses_the_packet_and_no_more(silent_port):
    """A terminal that nobody reads fills up; the packet counts as lost, the adapter is not taken for gone."""
    port = ServoPort(silent_port, BAUD)
    port.open()
    link = Link(port)
    for _ in range(2000):
        link.write_all(t.GOAL_POSITION, dict.fromkeys(range(12), 2048))
        if link.counters.lost:
            break
    assert link.counters.lost == 1
    assert link.read_all([1, 2], (126, 10)) == {}


class Babble:
    """A serial device on which bytes never end; each look at it takes its time by the port's clock."""

    in_waiting = 4096

    def __init__(self, pattern):
        self._coming = itertools.cycle(pattern)

    def read(self, length):
        return bytes(itertools.islice(self._coming, length))

    def write(self, data):
        return len(data)

    def reset_input_buffer(self):
        return


class SlowClock(ServoPort):
    """A port on that device; every question after the time takes 0.05 ms of it."""

    def __init__(self, pattern):
        self.now_ms = 0.0
        super().__init__("babble", BAUD)
        self.ser, self.tx_time_per_byte = Babble(pattern), 10_000.0 / BAUD

    def getCurrentTime(self):
        self.now_ms += 0.05
        return self.now_ms


STRANGER = framing(2.0).status(200, 0, bytes(10))


@pytest.mark.parametrize(
    "pattern",
    [b"\0", b"\xff", b"\xff\xff\xfd\0", bytes(range(256)), STRANGER],
    ids=["zeros", "ones", "headers", "counting", "a stranger's packets"],
)
@pytest.mark.parametrize("what", ["all", "one", "roll call"])
def test_bytes_that_keep_coming_do_not_keep_a_read_from_its_end(pattern, what):
    port = SlowClock(pattern)
    link, ended = Link(port), []
    read = {
        "all": lambda: link.read_all(range(1, 13), t.FAST_BLOCK),
        "one": lambda: link.ping(1, tries=1),
        "roll call": link.ping_all,
    }[what]
    reading = threading.Thread(target=lambda: ended.append(read()), daemon=True)
    reading.start()
    reading.join(PATIENCE_S)
    assert ended in ([{}], [None])
    all_ms, roll_ms = 12 * 21 * port.tx_time_per_byte + PATIENCE_MS, 3.0 * 253 + 14 * 253 * port.tx_time_per_byte
    most_ms = {"all": all_ms, "one": PING_PATIENCE_MS + 1, "roll call": roll_ms + link_module.PATIENCE_MS}
    assert port.now_ms < most_ms[what] + 1.0


class Turns:
    """A serial device, and the clock of its port, on which servos answer a broadcast ping in their turns."""

    def __init__(self, monkeypatch, baud, servos):
        self.now_ms, self.coming, self.due = 0.0, b"", []
        self.port = ServoPort("turns", baud)
        self.port.ser, self.port.tx_time_per_byte = self, 10_000.0 / baud
        monkeypatch.setattr(self.port, "getCurrentTime", lambda: self.now_ms)
        monkeypatch.setattr("host.bus.dynamixel.port.select.select", self.select)
        for before, servo in enumerate(servos):
            at_ms = (10 + 14 * (before + 1)) * self.port.tx_time_per_byte + 3.0 * (servo - before) + 0.5
            self.due.append((at_ms, framing(2.0).status(servo, 0, bytes([30, 0, 45]))))

    def select(self, reading, writing, failing, left_s):
        """Sleep until an answer is there, or so long."""
        self.now_ms = min([self.now_ms + 1000 * left_s + 0.01, *[at_ms for at_ms, _ in self.due]])

    @property
    def in_waiting(self):
        while self.due and self.due[0][0] <= self.now_ms:
            self.coming += self.due.pop(0)[1]
        return len(self.coming)

    def read(self, length):
        data, self.coming = self.coming[:length], self.coming[length:]
        return data

    def write(self, data):
        return len(data)

    def fileno(self):
        return -1

    def reset_input_buffer(self):
        self.coming = b""


@pytest.mark.parametrize("servos", [[], [252], list(range(1, 13)), list(range(253))], ids=["0", "last", "robot", "all"])
@pytest.mark.parametrize("baud", t.BAUDS)
def test_a_roll_call_waits_for_every_turn_and_no_longer(monkeypatch, baud, servos):
    line = Turns(monkeypatch, baud, servos)
    assert Link(line.port).ping_all() == dict.fromkeys(servos, 30)
    wire_ms = (24 + 14 * len(servos)) * line.port.tx_time_per_byte
    assert line.now_ms < wire_ms + 3.0 * 253 + link_module.PATIENCE_MS + 1.0


@pytest.mark.parametrize("baud", t.BAUDS)
def test_a_single_servo_is_heard_at_every_rate(monkeypatch, baud):
    """At 9600 baud the request alone takes 10 ms, longer than the patience of a ping."""
    assert Link(Turns(monkeypatch, baud, [0]).port).ping(0, tries=1) == 30


def test_the_emulated_servos_answer_in_their_turns(open_port):
    link = Link(open_port)
    tools.set_id(link, 3, 252)
    wait_until(lambda: sorted(link.ping_all()) == [1, 2, *range(4, 13), 252], "all are heard, though one comes last")
