"""Twelve servos as a Bus: one sync write and one sync read per cycle; voltage, heat and state of one leg at a time.

When the host falls silent, the servos' own bus watchdog stops them where they are, and another process lets go of them
(guardian.py). No servo confirms the packet that lets go, so it is sent again until each servo reports that it is off.
"""

import threading
import time
from collections.abc import Callable, Sequence
from math import inf, tau
from typing import Any

from ...robot.actuators import Servo
from ...robot.model import Robot
from ...util.errors import UserError
from ..base import JOINT_LABELS, JOINTS, Bus, Fault, Measured, checked_fraction, checked_goals
from . import table as t
from .calibration.data import Calibration, counts_per_rad, servo_of
from .guardian import Guardian
from .link import PATIENCE_MS, Answer, Link, ServoError, packet_of, protocol_of
from .port import latency_warning
from .table import Register

WATCHDOG_S = 0.2  # ten ticks of 50 Hz: longer than a harmless hiccup (chosen)
SLICES = 8  # cycles until every servo has reported voltage and heat, and state
SILENT = "does not answer: check its cable"
OFF_TRIES = 10  # at the end; each asks all servos whether they have let go
UNGUARDED = Fault("sit", "guardian", "the process that lets go of the servos if this one dies has ended: start again")
TORQUE_TRIES = 20  # each needs an answer from all twelve: at 2 % bad packets about every second one gets it


def control_settings(model: Servo) -> list[tuple[Register, int]]:
    """Return the settings with which a servo can hold goals, with the gains of the robot file."""
    return [
        (t.RETURN_DELAY, 0), (t.OPERATING_MODE, t.POSITION_CONTROL), (t.P_GAIN, model.p_gain), (t.I_GAIN, model.i_gain),
        (t.D_GAIN, model.d_gain), (t.PROFILE_VELOCITY, 0), (t.PROFILE_ACCELERATION, 0),
    ]  # fmt: skip


class ServoBus(Bus):
    """The servos of a calibrated robot on an open or closed port (ServoPort, or LoopbackPort in tests)."""

    kind = "servos"

    def __init__(
        self, robot: Robot, calibration: Calibration, port: Any, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self.robot, self.calibration, self.port = robot, calibration, port
        self.link = Link(port, protocol_of(robot), self.counters)
        self._clock, self._lock = clock, threading.RLock()
        self._ids = calibration.ids
        self._per_rad = counts_per_rad(robot)
        turn = servo_of(robot).counts_per_turn / tau
        self._speed_scale = [
            j.sign * t.VELOCITY_RAD_S * turn / k for j, k in zip(calibration.joints, self._per_rad, strict=True)
        ]
        self._pwm, self._cycle, self._tries = t.FULL_PWM, 0, 0
        self._torque = self._stopped = self._opened = False
        self._warnings: list[str] = []
        self._firmware: set[int] = set()
        self._guardian: Guardian | None = None
        self._position, self._speed, self._load = [0.0] * JOINTS, [0.0] * JOINTS, [0.0] * JOINTS
        self._temperature, self._voltage, self._error = [0.0] * JOINTS, [0.0] * JOINTS, [""] * JOINTS
        self._fast_s, self._slow_s = [-inf] * JOINTS, [-inf] * JOINTS

    @property
    def warnings(self) -> tuple[str, ...]:
        """See Bus."""
        return tuple(self._warnings)

    @property
    def firmware(self) -> str:
        """See Bus."""
        return ", ".join(map(str, sorted(self._firmware)))

    def now(self) -> float:
        """See Bus."""
        return self._clock()

    def open(self) -> None:
        """See Bus: every servo must answer, be the right model and not have tripped."""
        self.port.open()
        self._opened = True
        try:
            self._warnings = [warning] if (warning := latency_warning(self.port.port_name)) else []
            self._find_all()
            for joint, servo in enumerate(self._ids):
                self._set_up(joint, servo)
            if self.port.is_real:
                packet = packet_of(self.link.protocol, t.TORQUE_ENABLE, dict.fromkeys(self._ids, 0))
                self._guardian = Guardian(self.port.ser.fileno(), packet)
        except BaseException:
            self.close()
            raise

    def _find_all(self) -> None:
        models = [self.link.ping(servo) for servo in self._ids]
        missing = [self.name(joint) for joint, model in enumerate(models) if model is None]
        if len(missing) == JOINTS:
            raise ServoError(
                f"{self.port.port_name}: no servo answers at {self.port.getBaudRate()} baud: is the power on? "
                f"look for other rates and ids with: caramelo servos scan --all-bauds"
            )
        if missing:
            raise ServoError(f"no answer from {', '.join(missing)}: {self._strangers()}")
        for joint, model in enumerate(models):
            if model != t.MODEL_MX28_V2:
                old = " (old firmware: update it with Dynamixel Wizard)" * (model == t.MODEL_MX28_V1)
                raise ServoError(f"{self.name(joint)} is model {model}, not {t.MODEL_MX28_V2}, MX-28(2.0){old}")

    def _strangers(self) -> str:
        """Return what to do about missing servos: renumber one with a foreign id, or check the cable."""
        if self.link.protocol == 1.0:
            return "check its cable and id with: caramelo servos scan"
        foreign = sorted(set(self.link.ping_all()) - set(self._ids))
        if foreign:
            ids = ", ".join(map(str, foreign))
            return (
                f"but from an id that belongs to no joint: {ids}; wrong id? caramelo servos set-id {foreign[0]} NEW"
            )
        return "check its cable and power, and that no other servo has the same id"

    def _set_up(self, joint: int, servo: int) -> None:
        link, model = self.link, servo_of(self.robot)
        firmware = link.read(servo, t.FIRMWARE)
        self._firmware.add(firmware)
        if firmware < t.WATCHDOG_FIRMWARE:
            raise ServoError(f"{self.name(joint)}: firmware below {t.WATCHDOG_FIRMWARE} has no bus watchdog: update it")
        link.set_up(servo, self.name(joint), [(t.STATUS_LEVEL, 2), *control_settings(model)])

    def name(self, joint: int) -> str:
        """See Bus: with the servo's id."""
        return f"{JOINT_LABELS[joint]} (id {self._ids[joint]})"

    def read(self) -> Measured:
        """See Bus: position, speed, load of all; voltage and heat, or state, of three."""
        with self._lock:
            now_s = self._clock()
            self._beat()
            self._take_fast(now_s)
            self._take_slice(now_s)
            if self._stopped:
                self._let_go()
        guarded = self._guardian is None or self._guardian.alive
        return Measured(
            time_s=now_s,
            position_rad=tuple(self._position),
            speed_rad_s=tuple(self._speed),
            load=tuple(self._load),
            temperature_C=tuple(self._temperature),
            voltage_V=tuple(self._voltage),
            error=tuple(self._error),
            age_s=tuple(now_s - at for at in self._fast_s),
            slow_age_s=tuple(now_s - at for at in self._slow_s),
            faults=() if guarded else (UNGUARDED,),
        )

    def _beat(self) -> None:
        if self._guardian is not None:
            self._guardian.beat(self._torque)

    def _answers(self, block: tuple[int, int], joints: Sequence[int] = range(JOINTS)) -> dict[int, Answer]:
        """Return the good answers to one request for (address, length), by joint."""
        answers = self.link.read_all([self._ids[joint] for joint in joints], block)
        return {joint: answers[self._ids[joint]] for joint in joints if self._ids[joint] in answers}

    def _take_fast(self, now_s: float) -> None:
        answers, alerted = self._answers(t.FAST_BLOCK), []
        for joint, mount in enumerate(self.calibration.joints):
            answer = answers.get(joint)
            if answer is None:
                self.counters.per_joint_lost[joint] += 1
                continue
            self._position[joint] = mount.angle_rad(answer.value(t.PRESENT_POSITION), self._per_rad[joint])
            self._speed[joint] = answer.value(t.PRESENT_VELOCITY) * self._speed_scale[joint]
            self._load[joint] = mount.sign * answer.value(t.PRESENT_LOAD) * t.LOAD_SHARE
            self._fast_s[joint] = now_s
            if answer.alert and not self._error[joint]:
                alerted.append(joint)
        if alerted:
            self._ask_trouble(alerted)

    def _ask_trouble(self, joints: list[int]) -> None:
        """Ask servos with the alert flag what is wrong."""
        register = t.HARDWARE_ERROR
        for joint, answer in self._answers((register.address, register.size), joints).items():
            self._error[joint] = t.hardware_error_text(answer.value(register))

    def _take_slice(self, now_s: float) -> None:
        """Ask one leg: for voltage and heat in one round, for torque, errors and watchdog in the next."""
        self._cycle = (self._cycle + 1) % SLICES
        joints = range(self._cycle % 4 * 3, self._cycle % 4 * 3 + 3)
        block = t.SLOW_BLOCK if self._cycle < 4 else t.STATE_BLOCK
        for joint, answer in self._answers(block, joints).items():
            if block is t.SLOW_BLOCK:
                self._voltage[joint] = answer.value(t.PRESENT_VOLTAGE) * t.VOLTS
                self._temperature[joint] = float(answer.value(t.PRESENT_TEMPERATURE))
                self._slow_s[joint] = now_s
            else:
                self._look_at_state(joint, answer)

    def _look_at_state(self, joint: int, answer: Answer) -> None:
        """Store what is wrong with a servo's state; resend a torque limit that it missed."""

        error = t.hardware_error_text(answer.value(t.HARDWARE_ERROR))
        if self._torque and not error:
            if answer.value(t.WATCHDOG) == t.WATCHDOG_TRIPPED:
                error = f"heard nothing for {WATCHDOG_S:g} s and stopped"
            elif not answer.value(t.TORQUE_ENABLE):
                error = "let go by itself: did it lose power?"
            elif answer.value(t.GOAL_PWM) != self._pwm:
                self.link.write_all(t.GOAL_PWM, {self._ids[joint]: self._pwm})
        self._error[joint] = error

    def write(self, goals_rad: Sequence[float]) -> None:
        """See Bus; goals beyond a joint's calibrated limits are limited."""
        goals = checked_goals(goals_rad)
        rows = zip(self._ids, self.calibration.joints, goals, self._per_rad, strict=True)
        counts = {servo: mount.limited_counts(goal, per_rad) for servo, mount, goal, per_rad in rows}
        with self._lock:
            if self._torque and not self._stopped:
                self._beat()
                self.link.write_all(t.GOAL_POSITION, counts)

    def limit_torque(self, fraction: float) -> None:
        """See Bus: the servo's Goal PWM register, which limits its duty in position control."""
        pwm = round(checked_fraction(fraction) * t.FULL_PWM)
        with self._lock:
            if pwm != self._pwm:
                self._pwm = pwm
                self._tell_all(t.GOAL_PWM, pwm)

    def torque(self, on: bool) -> None:
        """See Bus. Switching on clears an emergency stop; ServoError names a servo that does not hold."""
        with self._lock:
            if not on:
                self._torque, self._tries = False, 0
                self._let_go()
                return
            with self.link.patient(PATIENCE_MS):  # no control loop waits here
                while not self._hold_here():
                    continue

    def try_torque(self) -> bool:
        """See Bus. Between two tries all servos are off."""
        with self._lock:
            holds = self._hold_here()
            if not holds:
                self._let_go()
            return holds

    def _hold_here(self) -> bool:
        """Torque on with the present positions as goals, watchdog running; checked, as servos do not confirm it."""
        self._stopped = False
        present = self._answers(t.FAST_BLOCK)
        silent = [joint for joint in range(JOINTS) if joint not in present]
        if not silent:
            self._switch_on(present)
        reasons = dict.fromkeys(silent, SILENT) or self._not_holding()
        self._tries += 1
        if reasons and self._tries < TORQUE_TRIES:
            return False
        self._tries = 0
        if reasons:
            self._let_go()
            joint, why = next(iter(reasons.items()))
            raise ServoError(f"{self.name(joint)} does not hold: {why}; nothing moves")
        self._error, self._torque = [""] * JOINTS, True
        return True

    def _switch_on(self, present: dict[int, Answer]) -> None:
        """Switch torque on with goals where the servos are."""
        if self._guardian is not None:
            self._guardian.beat(True)
        self._tell_all(t.WATCHDOG, 0)
        self._tell_all(t.GOAL_PWM, self._pwm)
        positions = {self._ids[joint]: answer.value(t.PRESENT_POSITION) for joint, answer in present.items()}
        goals = {servo: min(max(at, 0), t.COUNTS_PER_TURN - 1) for servo, at in positions.items()}
        self.link.write_all(t.GOAL_POSITION, goals)
        self._tell_all(t.TORQUE_ENABLE, 1)
        self._tell_all(t.WATCHDOG, round(WATCHDOG_S / t.WATCHDOG_TICK_S))

    def _not_holding(self) -> dict[int, str]:
        """Return the joints that do not hold, and why."""
        answers, reasons = self._answers(t.STATE_BLOCK), {}
        for joint in range(JOINTS):
            answer = answers.get(joint)
            if answer is None:
                reasons[joint] = SILENT
            elif not answer.value(t.TORQUE_ENABLE):
                reasons[joint] = t.hardware_error_text(answer.value(t.HARDWARE_ERROR)) or "keeps its torque off"
            elif answer.value(t.WATCHDOG) != round(WATCHDOG_S / t.WATCHDOG_TICK_S):
                reasons[joint] = "its bus watchdog does not run"
        return reasons

    def emergency_stop(self) -> None:
        """See Bus. If another thread is talking, that thread also sends the stop right after its present cycle."""
        self._stopped = True
        self._torque = False
        with self._lock:
            self._tries = 0
            if self._opened:
                self._let_go()

    def _let_go(self) -> None:
        self._tell_all(t.TORQUE_ENABLE, 0)
        self._tell_all(t.TORQUE_ENABLE, 0)

    def _let_go_for_good(self) -> None:
        """Let go until all servos confirm it, or have been asked often enough."""
        for _ in range(OFF_TRIES):
            self._let_go()
            answers = self._answers((t.TORQUE_ENABLE.address, t.TORQUE_ENABLE.size))
            if sum(not answer.data[0] for answer in answers.values()) == JOINTS:
                return

    def _tell_all(self, register: Register, value: int) -> None:
        self.link.write_all(register, dict.fromkeys(self._ids, value))

    def close(self) -> None:
        """See Bus: torque off, and the port closed even if the adapter is gone."""
        with self._lock:
            if not self._opened:
                return
            self._opened = self._torque = False
            try:
                self._let_go_for_good()
                self._tell_all(t.WATCHDOG, 0)
            except UserError as error:
                self._warnings.append(str(error))
            finally:
                if self._guardian is not None:
                    self._guardian.close()
                self.port.closePort()
