"""Emulated servos on a pseudo-terminal, in real time, in a process of their own: python -m host.sim.servos.

The first line on stdout is a JSON object with the port's name. After that each line on stdin is a JSON object with
what to do, answered by one line; see ``Commands``. The process ends when stdin does.
"""

import argparse
import json
import os
import pty
import select
import sys
import termios
import time
import tty
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...bus.dynamixel import table as t
from ...bus.dynamixel.calibration.data import load_calibration, nominal
from ...bus.dynamixel.link import protocol_of
from ...robot.file import load_robot
from ...robot.model import Robot
from ...robot.poses import seated_pose_rad
from ..imu import SimulatedImu
from ..plant import JointPlant, PlanePlant, Plant
from .bus import Disturbance, EmulatedBus
from .tray import plug, unpack

TICK_S = 0.005
CHUNK = 4096


class Commands:
    """The emulator's commands while it runs; each returns its answer."""

    def __init__(self, bus: EmulatedBus, imu: SimulatedImu) -> None:
        self._bus, self._imu = bus, imu

    def do(self, order: dict[str, Any]) -> dict[str, Any]:
        """Carry out one command; the answer says if it can't."""
        try:
            name = order.pop("do")
            answer: dict[str, Any] = getattr(self, f"on_{name}")(**order)
        except (KeyError, AttributeError, TypeError, ValueError) as error:
            return {"error": f"{type(error).__name__}: {error}"}
        return answer

    def on_trip(self, servo: int, bits: int = t.OVERLOADED) -> dict[str, Any]:
        """Raise hardware errors of a servo."""
        self._bus.servo(servo).trip(bits)
        return {}

    def on_put(self, servo: int, register: str, value: int) -> dict[str, Any]:
        """Set any register of a servo, such as its temperature."""
        self._bus.servo(servo).put(t.REGISTERS[register], value)
        return {}

    def on_put_all(self, register: str, value: int) -> dict[str, Any]:
        """Set a register of all servos, such as the voltage."""
        for servo in self._bus.servos:
            servo.put(t.REGISTERS[register], value)
        return {}

    def on_missing(self, servo: int, missing: bool = True) -> dict[str, Any]:
        """Pull a servo's plug, or put it back."""
        self._bus.servo(servo).missing = missing
        return {}

    def on_plug(self, joints: list[int]) -> dict[str, Any]:
        """Plug in the servos of these joints and no others."""
        plug(self._bus, joints)
        return {}

    def on_disturb(self, lost: float, corrupted: float) -> dict[str, Any]:
        """Lose and damage shares of the packets."""
        self._bus.disturbance.lost, self._bus.disturbance.corrupted = lost, corrupted
        return {}

    def on_imu(self) -> dict[str, Any]:
        """Read the simulated inertial sensor; in space tell where the body is, too."""
        plant = self._bus.plant
        place = {"place": plant.place()} if hasattr(plant, "place") else {}
        return {"counts": self._imu.read(), **place}

    def on_ground(self, name: str) -> dict[str, Any]:
        """Put the robot in space down on another ground."""
        from ..space.plant import SpacePlant
        from ..stage import ground

        plant = self._bus.plant
        if not isinstance(plant, SpacePlant):
            raise ValueError("only in space")
        plant.set_ground(ground(name))
        return {}

    def on_push(self, servo: int, angle_rad: float) -> dict[str, Any]:
        """Turn the joint of a loose servo by hand."""
        self._bus.plant.push(self._bus.servo(servo).joint, angle_rad)
        return {}

    def on_put_back(self) -> dict[str, Any]:
        """Lift the robot and put it down seated, as a person does after a fall."""
        self._bus.plant.put_back()
        return {}

    def on_state(self) -> dict[str, Any]:
        """Tell which servos have torque, which obey goals, and where the joints are."""
        servos, plant, noise = self._bus.servos, self._bus.plant, self._bus.disturbance
        return {
            "time_s": plant.time_s,
            "torque": [bool(servo.get(t.TORQUE_ENABLE)) for servo in servos],
            "follows": [servo.follows for servo in servos],
            "watchdog": [servo.get(t.WATCHDOG) for servo in servos],
            "position_rad": plant.position_rad,
            "goal_rad": plant.drives.goal_rad,
            "refused": sum(servo.refused for servo in servos),
            "packets": noise.packets,
            "lost": noise.lost_packets,
            "corrupted": noise.corrupted_packets,
        }


def arguments() -> argparse.Namespace:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="caramelo")
    parser.add_argument("--plant", choices=("ground", "bench", "space"), default="ground")
    parser.add_argument("--honest", action="store_true", default=None, help="default: as the robot file says")
    parser.add_argument("--simple", dest="honest", action="store_false")
    parser.add_argument("--truth", type=Path, help="calibration file that says how the servos are mounted")
    parser.add_argument("--new", action="store_true", help="servos fresh from the box, none plugged in")
    parser.add_argument("--lost", type=float, default=0.0)
    parser.add_argument("--corrupted", type=float, default=0.0)
    parser.add_argument("--latency-ms", type=float, default=1.0, help="delay of the adapter's answers")
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


def make_plant(kind: str, robot: Robot, seed: int) -> Plant:
    """Return the body that the servos move, seated."""
    pose = seated_pose_rad(robot)
    if kind == "bench":
        return JointPlant(robot, pose)
    if kind == "ground":
        return PlanePlant(robot, pose, seed)
    from ..space.plant import SpacePlant

    return SpacePlant(robot)


def build(options: argparse.Namespace) -> tuple[EmulatedBus, SimulatedImu]:
    """Return the servos and the sensor of a robot that waits seated."""
    robot = load_robot(options.robot).simulated(options.honest)
    truth = load_calibration(options.truth, robot) if options.truth else nominal(robot)
    plant = make_plant(options.plant, robot, options.seed)
    noise = Disturbance(options.lost, options.corrupted, options.seed)
    bus = EmulatedBus(robot, plant, truth, protocol_of(robot), noise)
    if options.new:
        unpack(bus)
    return bus, SimulatedImu(robot, plant.inertial, options.seed)


def baud_of(terminal: int) -> int | None:
    """Return the rate that the other side has set, or None for one that has no constant."""
    speed = termios.tcgetattr(terminal)[5]
    rates = {getattr(termios, f"B{baud}"): baud for baud in t.BAUDS if hasattr(termios, f"B{baud}")}
    return rates.get(speed)


def tell(answer: Mapping[str, Any]) -> None:
    """Write one line to the parent process, unbuffered, so that nothing is written again at the end."""
    os.write(1, json.dumps(answer).encode() + b"\n")


def serve(bus: EmulatedBus, commands: Commands, latency_s: float) -> None:
    """Answer packets and orders until stdin ends."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    bus.advance(TICK_S)  # so that slow first calls do not delay the first answer
    # Until a program sets a rate, the terminal has its own, which no servo listens to.
    tell({"port": os.ttyname(theirs)})
    began = time.monotonic()
    orders = b""
    coming: list[tuple[float, bytes]] = []  # answers that wait for their turn, and when that is
    while True:
        ready, _, _ = select.select([ours, 0], [], [], TICK_S)
        now_s = time.monotonic() - began
        bus.advance(now_s)
        if ours in ready:
            answers = bus.receive(os.read(ours, CHUNK), now_s, baud_of(theirs))
            coming = [(now_s + delay_s, answer) for delay_s, answer in zip(bus.delays_s(answers), answers, strict=True)]
            time.sleep(latency_s if answers else 0.0)
        due = b"".join(answer for at_s, answer in coming if at_s <= now_s)
        if due:
            os.write(ours, due)
            coming = [(at_s, answer) for at_s, answer in coming if at_s > now_s]
        if 0 in ready:
            data = os.read(0, CHUNK)
            if not data:
                return
            *lines, orders = (orders + data).split(b"\n")
            for line in lines:
                tell(commands.do(json.loads(line)))


def main() -> int:
    """Run until stdin ends."""
    options = arguments()
    bus, imu = build(options)
    imu.open()
    try:
        serve(bus, Commands(bus, imu), options.latency_ms / 1000)
    except BrokenPipeError:
        return 1  # the parent process is gone before it could close our input
    return 0


if __name__ == "__main__":
    sys.exit(main())
