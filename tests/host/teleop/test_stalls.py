"""Nothing that the loop waits for can hold it up: servos and sensor of a process that stands still, a bad line."""

import os
import signal

import pytest

from host.bus.dynamixel.bus import TORQUE_TRIES
from host.commands._hardware import hardware
from host.control.loop import Loop
from host.control.supervisor import Supervisor
from host.robot.file import load_robot
from host.sim.servos.process import Emulator, Late
from host.util.errors import UserError
from tests.host.bus.dynamixel.rig import Rig as Servos
from tests.host.control.rig import RESET, SCRIPT, STAND, Silence
from tests.waiting import wait_until

ROBOT = load_robot("caramelo")


def holds(loop):
    """Ask to stand, do a tick, and return whether the joints hold and all of them have just answered.

    A busy machine may not get to its emulated servos for so long that this is a fault: then it is reset.
    """
    if loop.supervisor.safety.first is not None:
        loop.receive(SCRIPT, RESET)
    loop.receive(SCRIPT, STAND)
    loop.tick(Silence())
    return loop.supervisor.armed and not any(loop.supervisor.measured.age_s)


def test_servos_that_stand_still_do_not_stop_the_loop():
    """An emulator that is halted answers nothing at all; each tick still ends, and what is missing is a fault."""
    with hardware(ROBOT, "emulated") as parts, parts.bus:
        attitude, emulator = parts.attitude, parts.attitude.source.emulator
        attitude.open()
        loop = Loop(Supervisor(ROBOT, parts.bus, attitude.update))
        wait_until(lambda: holds(loop), lambda: loop.supervisor.safety.sentence)
        lost, missed = parts.bus.counters.lost, attitude.missed
        os.kill(emulator.process, signal.SIGSTOP)
        try:
            for _ in range(40):
                loop.tick(Silence())
        finally:
            os.kill(emulator.process, signal.SIGCONT)
        assert parts.bus.counters.lost - lost >= 12 * 40
        assert attitude.missed > missed
        assert attitude.fault == "the emulated IMU does not answer in time: this machine may be too busy"
        assert loop.supervisor.safety.first.cause == "bus"
        assert not loop.supervisor.armed
        wait_until(lambda: loop.tick(Silence()) or not attitude.fault, "the sensor is taken again once it answers")


def test_late_answers_are_thrown_away_and_do_not_pile_up():
    with Emulator("--plant", "bench") as emulator:
        os.kill(emulator.process, signal.SIGSTOP)
        for _ in range(30):
            with pytest.raises(Late):
                emulator.ask("imu", 0.001)
        os.kill(emulator.process, signal.SIGCONT)
        assert emulator.ask("state")["torque"] == [False] * 12
        assert len(emulator.ask("imu")["counts"]) == 6


def test_switching_on_over_a_bad_line_takes_a_try_a_tick():
    rig = Servos()
    rig.bus.open()
    rig.noise.lost = 1.0
    asked = rig.bus.counters.sent
    assert not rig.bus.try_torque()
    assert rig.bus.counters.sent - asked == 12, "all positions, once"
    rig.noise.lost = 0.0
    assert rig.bus.try_torque()
    assert all(servo.follows for servo in rig.servos)


def test_a_servo_that_never_holds_ends_the_tries_and_no_other_holds_meanwhile():
    rig = Servos()
    rig.bus.open()
    rig.servos[7].missing = True
    for _ in range(TORQUE_TRIES - 1):
        assert not rig.bus.try_torque()
        assert not any(servo.follows for servo in rig.servos)
    with pytest.raises(UserError, match=r"RR thigh \(id 8\) does not hold: does not answer: check its cable"):
        rig.bus.try_torque()
