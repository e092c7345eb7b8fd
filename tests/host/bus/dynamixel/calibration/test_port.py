"""The calibration through a real port, in real time: emulated servos on a stand, mounted as only the emulator knows."""

import contextlib
import time

from host.bus.base import JOINT_LABELS
from host.bus.dynamixel.bus import ServoBus
from host.bus.dynamixel.calibration.bench import Bench
from host.bus.dynamixel.calibration.data import load_calibration, save_calibration
from host.bus.dynamixel.calibration.procedure import Procedure, reference_rad
from host.bus.dynamixel.link import Link, ServoError
from host.bus.dynamixel.port import ServoPort
from host.robot.file import load_robot
from host.sim.servos.process import Emulator
from host.sim.servos.stand import hidden_mounting

CARAMELO = load_robot("caramelo")
LEFT = 1  # servos to calibrate here; the others are in the file of what was done before


class Watcher(Bench):
    """A bench that remembers which way a servo went, as one who looks at the robot does."""

    went = 0

    def nudge(self, servo):
        self.went = super().nudge(servo)
        return self.went


class Person:
    """Answers what is to be seen, and turns joints by hand."""

    def __init__(self, emulator, truth, bench):
        self.emulator, self.truth, self.bench, self.answers = emulator, truth, bench, {}

    def say(self, text):
        """Read it."""

    def ask(self, key, question, choices):
        if key == "resume":
            return "yes"
        servo = int(key.split()[1])
        joint = self.truth.ids.index(servo)
        if key.endswith("joint"):
            return JOINT_LABELS[joint]
        if key.endswith("direction"):
            return "+" if self.bench.went == self.truth.joints[joint].sign else "-"
        if key.endswith("reference"):
            self.emulator.ask("push", servo=servo, angle_rad=reference_rad(CARAMELO, joint))
            return ""
        return "file"

    def refuse(self, key, reason):
        raise AssertionError(f"{key}: {reason}")


def test_a_calibration_through_the_port_and_the_robot_that_it_opens(tmp_path):
    truth = hidden_mounting(CARAMELO, 3)
    path, keep = tmp_path / "truth.toml", tmp_path / "unfinished"
    save_calibration(path, truth)
    with Emulator("--plant", "bench", "--truth", str(path)) as emulator:
        port = ServoPort(emulator.port, CARAMELO.bus.baud)
        port.open()
        bench = Watcher(Link(port), time.sleep)
        run = Procedure(CARAMELO, bench, Person(emulator, truth, bench), keep)
        last = sorted(truth.ids)[-LEFT:]
        run.done = {joint: mount for joint, mount in enumerate(truth.joints) if mount.id not in last}
        run.save()
        found = None
        for _ in range(10):  # a servo that a busy machine left alone for 0.2 s stops, and one begins with it again
            with contextlib.suppress(ServoError):
                found = run.run()
                break
        assert found == truth
        assert not any(emulator.ask("state")["torque"])
        port.closePort()
        save_calibration(tmp_path / "found.toml", found)
        data = load_calibration(tmp_path / "found.toml", CARAMELO)
        with ServoBus(CARAMELO, data, ServoPort(emulator.port, CARAMELO.bus.baud)) as bus:
            measured = bus.read()
            for _ in range(200):
                if measured.complete:
                    break
                measured = bus.read()
            real = emulator.ask("state")["position_rad"]
        assert max(abs(a - b) for a, b in zip(measured.position_rad, real, strict=True)) < 0.01
