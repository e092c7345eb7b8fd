"""One emulated MX-28(2.0): its control table, and the servo's own reactions to changes of it.

After the e-manual's MX-28(2.0) page: when the bus watchdog trips, the servo stops and takes no goals, but its torque
stays on; so it holds where it is, here too. Left out: profiles, indirect addresses, registered writes, other operating
modes than position control.
"""

from math import tau

from ...bus.dynamixel import table as t
from ...bus.dynamixel.calibration.data import JointCalibration
from ...bus.dynamixel.table import Register
from ..plant import Plant

STILL_V = 12.0
ROOM_C = 30


class EmulatedServo:
    """A servo on one joint of a plant; ``mount`` says how it sits there."""

    def __init__(self, joint: int, mount: JointCalibration, per_rad: float, plant: Plant) -> None:
        self.joint, self.mount, self.per_rad, self.plant = joint, mount, per_rad, plant
        self.memory = bytearray(t.TABLE_SIZE)
        self.missing = False
        self.heard_s = 0.0
        self.refused = 0
        for register in t.REGISTERS.values():
            self.put(register, register.initial)
        self.put(t.ID, mount.id)
        self.put(t.PRESENT_VOLTAGE, round(STILL_V / t.VOLTS))
        self.put(t.PRESENT_TEMPERATURE, ROOM_C)
        self.observe()

    @property
    def id(self) -> int:
        """The servo's id, as its register has it."""
        return self.get(t.ID)

    @property
    def follows(self) -> bool:
        """True while it obeys goals: torque on and watchdog not tripped. Tripped, it still holds where it stopped."""
        return bool(self.get(t.TORQUE_ENABLE)) and self.get(t.WATCHDOG) != t.WATCHDOG_TRIPPED

    def get(self, register: Register) -> int:
        """Return a register."""
        return t.unpack(register, self.memory)

    def put(self, register: Register, value: int) -> None:
        """Set a register from inside, without any check."""
        self.memory[register.address : register.address + register.size] = bytes(t.pack(register, value))

    def read(self, address: int, size: int) -> tuple[int, bytes]:
        """Return error and bytes as READ does."""
        if address + size > t.TABLE_SIZE:
            return t.ACCESS_ERROR, b""
        self.observe()
        return 0, bytes(self.memory[address : address + size])

    def write(self, address: int, data: bytes) -> int:
        """Write as WRITE does: all registers in the range, or none; return the error."""
        touched = [r for r in t.REGISTERS.values() if r.address < address + len(data) and address < r.address + r.size]
        values = []
        for register in touched:
            at = register.address - address
            if at < 0 or at + register.size > len(data):
                return self._refuse(t.LENGTH_ERROR)
            values.append((register, t.unpack(register, data, address)))
        for register, value in values:
            error = self._error_of(register, value)
            if error:
                return self._refuse(error)
        for register, value in values:
            self._set(register, value)
        return 0 if values else self._refuse(t.ACCESS_ERROR)

    def _refuse(self, error: int) -> int:
        self.refused += 1
        return error

    def _error_of(self, register: Register, value: int) -> int:
        if not register.writable or (register.eeprom and self.get(t.TORQUE_ENABLE)):
            return t.ACCESS_ERROR
        if not register.low <= value <= register.high:
            return t.RANGE_ERROR
        if register in (t.GOAL_POSITION, t.GOAL_PWM) and self.get(t.WATCHDOG) == t.WATCHDOG_TRIPPED:
            return t.RANGE_ERROR
        if register is t.GOAL_POSITION and not self.get(t.MIN_POSITION) <= value <= self.get(t.MAX_POSITION):
            return t.LIMIT_ERROR
        if register is t.GOAL_PWM and abs(value) > self.get(t.PWM_LIMIT):
            return t.LIMIT_ERROR
        return 0

    def _set(self, register: Register, value: int) -> None:
        if register is t.TORQUE_ENABLE and value and not self.get(t.TORQUE_ENABLE):
            if self.get(t.HARDWARE_ERROR) & self.get(t.SHUTDOWN):
                return  # after a shutdown only a restart brings the torque back
            self.observe()
            self.put(t.GOAL_POSITION, self.get(t.PRESENT_POSITION))
        self.put(register, value)
        self.drive()

    def reboot(self) -> None:
        """Restart: volatile registers as when new, hardware errors gone unless their cause is still there."""
        for register in t.REGISTERS.values():
            if not register.eeprom and register not in (t.PRESENT_VOLTAGE, t.PRESENT_TEMPERATURE):
                self.put(register, register.initial)
        self.drive()

    def trip(self, bits: int = t.OVERLOADED) -> None:
        """Raise hardware errors; those in the shutdown register take the torque away."""
        self.put(t.HARDWARE_ERROR, self.get(t.HARDWARE_ERROR) | bits)
        if bits & self.get(t.SHUTDOWN):
            self.put(t.TORQUE_ENABLE, 0)
        self.drive()

    def watch(self, now_s: float) -> None:
        """Look after itself: heat, and silence on the bus."""
        if self.get(t.PRESENT_TEMPERATURE) > self.get(t.TEMPERATURE_LIMIT):
            self.trip(t.OVERHEATED)
        ticks = self.get(t.WATCHDOG)
        if ticks > 0 and self.get(t.TORQUE_ENABLE) and now_s - self.heard_s > ticks * t.WATCHDOG_TICK_S:
            self.put(t.WATCHDOG, t.WATCHDOG_TRIPPED)
            self.observe()
            self.put(t.GOAL_POSITION, self.get(t.PRESENT_POSITION))
            self.drive()

    def observe(self) -> None:
        """Take position, speed and load from the plant into the registers."""
        plant, joint = self.plant, self.joint
        self.put(t.PRESENT_POSITION, self.mount.counts(plant.position_rad[joint], self.per_rad))
        motor_rad_s = plant.speed_rad_s[joint] * self.per_rad / (t.COUNTS_PER_TURN / tau)
        self.put(t.PRESENT_VELOCITY, self.mount.sign * round(motor_rad_s / t.VELOCITY_RAD_S))
        if plant.supply_V is not None:
            self.put(t.PRESENT_VOLTAGE, round(plant.supply_V / t.VOLTS))
        self.put(t.PRESENT_LOAD, self.mount.sign * round(plant.drives.load[joint] / t.LOAD_SHARE))

    def drive(self) -> None:
        """Hand goal, torque and limit to the plant."""
        drives, joint = self.plant.drives, self.joint
        drives.goal_rad[joint] = self.mount.angle_rad(self.get(t.GOAL_POSITION), self.per_rad)
        drives.on[joint] = bool(self.get(t.TORQUE_ENABLE))
        drives.limit[joint] = abs(self.get(t.GOAL_PWM)) / t.FULL_PWM
