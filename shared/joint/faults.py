"""Fault codes of a joint: one byte on the wire, with one value of 24 bits; host/robot/joint_faults.py has the words.

The unit of the value is given with each code. Faults at FAULT_COAST_FROM and above end the torque
at once; below, the joint damps first, because its sensing can still be trusted.
"""

from ..runtime import const, hot

FAULT_NONE = const(0)
# damp, then coast
FAULT_WATCHDOG = const(1)  # ms without a set-point
FAULT_OVER_SPEED = const(2)  # rate
FAULT_POSITION_LIMIT = const(3)  # rc, joint-signed
FAULT_STALL = const(4)  # cu
FAULT_WINDING_HOT = const(5)  # t16
FAULT_MCU_HOT = const(6)  # t16
FAULT_THERMISTOR_OPEN = const(7)  # count
FAULT_THERMISTOR_SHORT = const(8)  # count
FAULT_DUPLICATE_ID = const(9)  # node
FAULT_OVERRUN = const(10)  # late interrupts counted
FAULT_MCU_SENSOR = const(11)  # count
FAULT_JOINT_ENCODER_LOST = const(12)  # ms without a valid reading
# coast at once
FAULT_COAST_FROM = const(32)
FAULT_EMERGENCY_STOP = const(32)  # 0
FAULT_OVER_CURRENT = const(33)  # cu, length of the vector
FAULT_UNDER_VOLTAGE = const(34)  # vu
FAULT_OVER_VOLTAGE = const(35)  # vu
FAULT_ENCODER_LOST = const(36)  # readings rejected in the last ms
FAULT_ENCODER_DISAGREE = const(37)  # rc, joint encoder minus rotor
FAULT_CURRENT_SENSE = const(38)  # count, sum of the phases
FAULT_DRIVER = const(39)  # fault registers of the gate driver
FAULT_DRIVER_SETUP = const(40)  # address of the register that reads back differently
FAULT_EXCEPTION = const(41)  # where: 1 current step, 2 motion tick, 3 slow tick, 4 bus
FAULT_POSITION_RANGE = const(42)  # turns at which the position left its range
FAULT_STORAGE = const(43)  # 0
FAULT_INTERRUPT_STOPPED = const(44)  # ms without a current step
# commissioning and homing: why they ended
FAULT_COMMISSION_OFFSET = const(64)  # count, reading at no current
FAULT_COMMISSION_NOISE = const(65)  # count, peak to peak at no current
FAULT_COMMISSION_SUM = const(66)  # count, sum of the phases under current
FAULT_COMMISSION_BUS = const(67)  # vu
FAULT_COMMISSION_ENCODER = const(68)  # rc, noise at rest
FAULT_COMMISSION_NO_CURRENT = const(69)  # cu reached: no motor, or two phases open
FAULT_COMMISSION_NOT_FREE = const(70)  # rc moved instead of following the field
FAULT_COMMISSION_POLE_PAIRS = const(71)  # rc moved in the field's turns, which no whole number fits
FAULT_COMMISSION_PHASE_ORDER = const(72)  # direction found, +-1
FAULT_COMMISSION_FRICTION = const(73)  # brad, by which friction holds the rotor behind the field
FAULT_COMMISSION_JOINT_ENCODER = const(74)  # 1/16384 joint turn moved
FAULT_COMMISSION_MOVING = const(75)  # rate at the start
FAULT_COMMISSION_OFFSET_CHANGED = const(76)  # brad, found minus stored
FAULT_HOME_NO_STOP = const(77)  # ms looked for
FAULT_HOME_AMBIGUOUS = const(78)  # rc left between stop and nearest position
FAULT_COMMISSION_PHASE_OPEN = const(79)  # 1 .. 3: the phase without current
FAULT_COMMISSION_WINDING = const(80)  # gain or inductance that the current loop cannot have
FAULT_COMMISSION_END_STOP = const(81)  # rc moved until it stood
FAULT_COMMISSION_MAGNET = const(82)  # rc, amplitude of the eccentricity
FAULT_COMMISSION_FLUX = const(83)  # back-EMF that no motor has, in the unit of JointSettings.bemf
FAULT_COMMISSION_INERTIA = const(84)  # inertia, Q12, for which the velocity loop can have no gain
FAULT_COMMISSION_COGGING = const(85)  # cu: amplitude of a wave, or what could not turn the rotor
FAULT_COMMISSION_CURRENT_LOOP = const(86)  # per cent: its bandwidth of the wanted one
FAULT_COMMISSION_VELOCITY_LOOP = const(87)  # likewise
FAULT_COMMISSION_POSITION_LOOP = const(88)  # likewise
FAULT_COMMISSION_PLAY = const(89)  # rc between rotor and joint encoder
FAULT_COMMISSION_LOAD = const(90)  # ms that half of the current limit takes to the speed limit


@hot
def damps_first(code: int) -> int:
    """Return 1 if the joint may damp before it coasts after fault ``code`` (any number), else 0."""
    if code > FAULT_NONE and code < FAULT_COAST_FROM:
        return 1
    return 0
