"""A stop from each source of this machine, in real time, the loop in a thread: how long to torque off."""

import json
import os
import socket
import threading
import time

import pytest

from host.control.loop import Loop
from host.control.supervisor import Supervisor
from host.robot.file import load_robot
from host.sim.bus import SimulatedBus
from host.teleop import gamepad as pads
from host.teleop.hub import Hub
from host.teleop.keyboard import Keyboard
from tests.host.control.rig import RESET, SCRIPT, STOP
from tests.waiting import PATIENCE_S, let_pass, wait_until

from .test_devices import FakePad

AIMED_AT_S = 0.025


class ClockedBus(SimulatedBus):
    """Notes when the torque went off."""

    off_s = 0.0

    def emergency_stop(self):
        super().emergency_stop()
        self.off_s = time.monotonic()


class PipedPad(FakePad):
    """A pad that select() can wait for."""

    def __init__(self):
        super().__init__()
        self.reading, self.writing = os.pipe()

    def fileno(self):
        return self.reading

    def read(self):
        os.read(self.reading, 64)
        return super().read()

    def press_stop(self):
        self.say(pads.EV_KEY, pads.BTN_EAST, 1)
        os.write(self.writing, b"x")


@pytest.fixture
def running(tmp_path):
    """Yield the loop, and a function per source that pulls the stop."""
    robot = load_robot("caramelo")
    bus = ClockedBus(robot)
    bus.open()
    loop = Loop(Supervisor(robot, bus))
    hub = Hub(loop.receive, loop.drop)
    keys_out, keys_in = os.pipe()
    pad = PipedPad()
    hub.add_input(Keyboard(robot, loop.supervisor.fastest, keys_out))
    hub.add_input(pads.open_gamepad(robot, loop.supervisor.fastest, "/dev/input/event0", lambda path: pad))
    hub.listen(str(tmp_path / "stops"))
    thread = threading.Thread(target=loop.run, args=(hub,))
    thread.start()
    script = socket.socket(socket.AF_UNIX)
    script.connect(str(tmp_path / "stops"))
    line = json.dumps(STOP).encode() + b"\n"
    pulls = {
        "keyboard": lambda: os.write(keys_in, b" "),
        "gamepad": pad.press_stop,
        "script": lambda: script.sendall(line),
    }
    yield loop, bus, pulls
    loop.running = False
    thread.join(PATIENCE_S)
    script.close()
    hub.close()
    for descriptor in (keys_out, keys_in, pad.reading, pad.writing):
        os.close(descriptor)


@pytest.mark.parametrize("source", ["keyboard", "gamepad", "script"])
def test_stop_to_torque_off(running, source):
    loop, bus, pulls = running
    taken_s = []
    for number in range(12):
        let_pass(0.011 + 0.003 * number)  # another moment of the loop's period each time
        pulled_s = time.monotonic()
        pulls[source]()
        wait_until(lambda pulled_s=pulled_s: bus.off_s >= pulled_s, "the torque is off", every_s=0.0005)
        taken_s.append(bus.off_s - pulled_s)
        loop.receive(SCRIPT, RESET)
        loop.supervisor.arbiter.driver = None
    print(source, "stop to torque off, ms:", [round(1000 * each, 2) for each in sorted(taken_s)])
    assert sorted(taken_s)[len(taken_s) // 2] < 5 * AIMED_AT_S
