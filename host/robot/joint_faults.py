"""A joint's fault codes in words: what happened with which number, and what to do about it.

The value's unit belongs to the code (shared/joint/faults.py). With the joint's Units the sentence
is in SI; without them it is in the joint's own integers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees

from shared.joint import faults as f

from .joint_units import Units


@dataclass(frozen=True)
class Quantity:
    """How a value is told: SI unit and factor where the joint's Units are needed for it, else its own unit."""

    own_unit: str
    si_unit: str = ""
    factor: Callable[[Units], float] | None = None
    fixed: float = 1.0

    def tell(self, value: int, units: Units | None) -> str:
        """Return the value with its unit."""
        if self.factor is None:
            number = f"{value * self.fixed:.4g}" if self.fixed != 1.0 else str(value)
            return f"{number} {self.own_unit}".strip()
        if units is None:
            return f"{value} {self.own_unit}"
        return f"{value * self.factor(units):.4g} {self.si_unit}"


PLAIN = Quantity("")
MS = Quantity("ms")
COUNTS = Quantity("counts")
PERCENT = Quantity("%")
CELSIUS = Quantity("degrees C", fixed=1 / 16)
ELECTRICAL = Quantity("electrical degrees", fixed=360 / 65536)
AMPERE = Quantity("cu", "A", lambda units: units.ampere_per_cu)
VOLT = Quantity("vu", "V", lambda units: units.volt_per_vu)
DEGREE = Quantity("rotor counts", "degrees", lambda units: degrees(units.rad_per_rc))
RAD_S = Quantity("rate units", "rad/s", lambda units: units.rad_s_per_rate)


@dataclass(frozen=True)
class Words:
    """``sentence`` holds {} for the value with its unit, ``hint`` says what to do."""

    name: str
    sentence: str
    hint: str
    quantity: Quantity


WORDS: dict[int, Words] = {
    f.FAULT_NONE: Words(
        "none",
        "no fault",
        "nothing to do",
        PLAIN,
    ),
    f.FAULT_WATCHDOG: Words(
        "watchdog",
        "no set-point for {}",
        "the host stopped sending or the bus is broken; clear and arm again",
        MS,
    ),
    f.FAULT_OVER_SPEED: Words(
        "over-speed",
        "turned at {}",
        "lower the commanded speed or look for what pushes the joint",
        RAD_S,
    ),
    f.FAULT_POSITION_LIMIT: Words(
        "position limit",
        "moved out to {}",
        "move the joint back by hand, check its limits and zero",
        DEGREE,
    ),
    f.FAULT_STALL: Words(
        "stall",
        "pushed with {} without moving",
        "free the joint; if it is free, check the motor's three wires and their order, then commission",
        AMPERE,
    ),
    f.FAULT_WINDING_HOT: Words(
        "winding hot",
        "the winding is at {}",
        "let it cool; lower the load or improve the cooling",
        CELSIUS,
    ),
    f.FAULT_MCU_HOT: Words(
        "board hot",
        "the microcontroller is at {}",
        "let it cool; give the board air",
        CELSIUS,
    ),
    f.FAULT_THERMISTOR_OPEN: Words(
        "thermistor open",
        "the thermistor reads {}",
        "check its wire and connector",
        COUNTS,
    ),
    f.FAULT_THERMISTOR_SHORT: Words(
        "thermistor short",
        "the thermistor reads {}",
        "look for a short at its wire",
        COUNTS,
    ),
    f.FAULT_DUPLICATE_ID: Words(
        "duplicate id",
        "another joint sends as node {}",
        "give one of the two another id with set-id",
        PLAIN,
    ),
    f.FAULT_OVERRUN: Words(
        "overrun",
        "{} current steps came late",
        "report it with the log; lower the current loop's rate",
        PLAIN,
    ),
    f.FAULT_MCU_SENSOR: Words(
        "board sensor",
        "the temperature sensor of the microcontroller reads {}",
        "the board is defective",
        COUNTS,
    ),
    f.FAULT_JOINT_ENCODER_LOST: Words(
        "joint encoder lost",
        "no valid reading of the joint's encoder for {}",
        "check the encoder's connector and the distance of its magnet",
        MS,
    ),
    f.FAULT_EMERGENCY_STOP: Words(
        "emergency stop",
        "an emergency stop was asked for",
        "release it, then clear and arm again",
        PLAIN,
    ),
    f.FAULT_OVER_CURRENT: Words(
        "over-current",
        "the current reached {}",
        "look for a short between the phases; check the motor's three wires and their order, then commission",
        AMPERE,
    ),
    f.FAULT_UNDER_VOLTAGE: Words(
        "under-voltage",
        "the supply fell to {}",
        "charge the battery, check the supply's wires",
        VOLT,
    ),
    f.FAULT_OVER_VOLTAGE: Words(
        "over-voltage",
        "the supply rose to {}",
        "braking feeds the supply: brake slower or use a battery",
        VOLT,
    ),
    f.FAULT_ENCODER_LOST: Words(
        "encoder lost",
        "{} readings of the rotor encoder were rejected in one millisecond",
        "check the encoder's connector and the distance of its magnet",
        PLAIN,
    ),
    f.FAULT_ENCODER_DISAGREE: Words(
        "encoder disagreement",
        "joint and rotor encoder differ by {}",
        "check coupling and magnets, then home again; commission it again if a part was changed",
        DEGREE,
    ),
    f.FAULT_CURRENT_SENSE: Words(
        "current sensing",
        "the three phase currents add up to {} instead of 0",
        "commission it again; if it returns, a shunt or its amplifier is defective",
        COUNTS,
    ),
    f.FAULT_DRIVER: Words(
        "gate driver",
        "the gate driver reports {} in its fault registers",
        "look the bits up in docs/joint.md; often a short at the motor",
        PLAIN,
    ),
    f.FAULT_DRIVER_SETUP: Words(
        "gate driver setup",
        "register {} of the gate driver does not read back what was written or the hardware left its ready state",
        "switch the power off and on; then the board is defective",
        PLAIN,
    ),
    f.FAULT_EXCEPTION: Words(
        "exception",
        "the program failed in part {} (1 current step, 2 motion, 3 slow, 4 bus)",
        "report it with the log",
        PLAIN,
    ),
    f.FAULT_POSITION_RANGE: Words(
        "position range",
        "the rotor is {} turns from zero, beyond what a position can hold",
        "home again",
        PLAIN,
    ),
    f.FAULT_STORAGE: Words(
        "storage",
        "the stored parameters could not be read",
        "write and save them again",
        PLAIN,
    ),
    f.FAULT_INTERRUPT_STOPPED: Words(
        "interrupt stopped",
        "no current step for {}",
        "reset the board; report it with the log",
        MS,
    ),
    f.FAULT_COMMISSION_OFFSET: Words(
        "commissioning: offset",
        "a current sensor reads {} without current, 2048 expected",
        "a shunt amplifier is defective",
        COUNTS,
    ),
    f.FAULT_COMMISSION_NOISE: Words(
        "commissioning: noise",
        "a current sensor's noise is {}",
        "look for a loose wire or a switching supply nearby",
        COUNTS,
    ),
    f.FAULT_COMMISSION_SUM: Words(
        "commissioning: sum",
        "under current the three phases add up to {}",
        "a shunt amplifier or its gain is wrong",
        COUNTS,
    ),
    f.FAULT_COMMISSION_BUS: Words(
        "commissioning: supply",
        "the supply is at {}",
        "connect the right supply",
        VOLT,
    ),
    f.FAULT_COMMISSION_ENCODER: Words(
        "commissioning: encoder",
        "the rotor encoder wanders by {} at rest",
        "check its magnet",
        COUNTS,
    ),
    f.FAULT_COMMISSION_NO_CURRENT: Words(
        "commissioning: no current",
        "only {} flowed",
        "connect the motor: two of its wires or all are open, or the supply is too weak",
        AMPERE,
    ),
    f.FAULT_COMMISSION_NOT_FREE: Words(
        "commissioning: not free",
        "the rotor moved {} instead of following the field",
        "free the joint, lift the robot",
        COUNTS,
    ),
    f.FAULT_COMMISSION_POLE_PAIRS: Words(
        "commissioning: pole pairs",
        "the rotor moved {} in a number of the field's turns that no whole number of pole pairs fits",
        "free the joint; check that the rotor encoder's magnet does not slip",
        COUNTS,
    ),
    f.FAULT_COMMISSION_PHASE_ORDER: Words(
        "commissioning: phase order",
        "the rotor turns the other way than stored (direction {})",
        "two motor wires are exchanged: put them back, or commission anew",
        PLAIN,
    ),
    f.FAULT_COMMISSION_FRICTION: Words(
        "commissioning: friction",
        "friction holds the rotor {} behind the field",
        "free the joint; if it is free, raise current_limit_A, half of which turns the rotor",
        ELECTRICAL,
    ),
    f.FAULT_COMMISSION_JOINT_ENCODER: Words(
        "commissioning: joint encoder",
        "the joint encoder moved {} while the rotor turned",
        "check its magnet and coupling",
        COUNTS,
    ),
    f.FAULT_COMMISSION_MOVING: Words(
        "commissioning: moving",
        "the joint turns at {}",
        "hold it still",
        RAD_S,
    ),
    f.FAULT_COMMISSION_OFFSET_CHANGED: Words(
        "commissioning: offset changed",
        "the rotor offset is {} from the stored one",
        "commission anew; the magnet has slipped",
        ELECTRICAL,
    ),
    f.FAULT_HOME_NO_STOP: Words(
        "homing: no stop",
        "no stop found in {}",
        "check the direction of the search and the joint's stop",
        MS,
    ),
    f.FAULT_HOME_AMBIGUOUS: Words(
        "homing: ambiguous",
        "the stop found at {} does not fit the rotor's angle",
        "check what stopped the joint; commission the stop's position",
        DEGREE,
    ),
    f.FAULT_COMMISSION_PHASE_OPEN: Words(
        "commissioning: phase open",
        "phase {} of 3 carries no current",
        "check this wire of the motor, its plug and its winding",
        PLAIN,
    ),
    f.FAULT_COMMISSION_WINDING: Words(
        "commissioning: winding",
        "resistance or inductance gives the current loop a gain of {}, which it cannot have",
        "look for a short in the winding; else change current_bandwidth_hz",
        PLAIN,
    ),
    f.FAULT_COMMISSION_END_STOP: Words(
        "commissioning: end stop",
        "the rotor stood after {} and did not go round",
        "move the joint to the middle of its range: the rotor needs one turn either way",
        COUNTS,
    ),
    f.FAULT_COMMISSION_MAGNET: Words(
        "commissioning: magnet",
        "the rotor encoder's readings are bent by {} either way",
        "centre its magnet on the shaft",
        COUNTS,
    ),
    f.FAULT_COMMISSION_FLUX: Words(
        "commissioning: flux",
        "a back-EMF of {} was found, which no motor of this supply has",
        "check the rotor's magnets and the supply's voltage",
        PLAIN,
    ),
    f.FAULT_COMMISSION_INERTIA: Words(
        "commissioning: inertia",
        "an inertia of {} was found, for which the velocity loop can have no gain",
        "check that the joint swings freely; else change velocity_bandwidth_hz",
        PLAIN,
    ),
    f.FAULT_COMMISSION_COGGING: Words(
        "commissioning: cogging",
        "the rotor's cogging takes {}, more than can be held against",
        "check that nothing rubs once or more often a turn; else this motor is too rough for its current limit",
        AMPERE,
    ),
    f.FAULT_COMMISSION_CURRENT_LOOP: Words(
        "commissioning: current loop",
        "the current loop has {} of the wanted bandwidth",
        "commission it again; if it returns, the winding is not linear: change current_bandwidth_hz",
        PERCENT,
    ),
    f.FAULT_COMMISSION_VELOCITY_LOOP: Words(
        "commissioning: velocity loop",
        "the velocity loop has {} of the wanted bandwidth",
        "look for what the joint carries or touches; else change velocity_bandwidth_hz",
        PERCENT,
    ),
    f.FAULT_COMMISSION_POSITION_LOOP: Words(
        "commissioning: position loop",
        "the position loop has {} of the wanted bandwidth",
        "look for what the joint touches; else change position_bandwidth_hz",
        PERCENT,
    ),
    f.FAULT_COMMISSION_LOAD: Words(
        "commissioning: load",
        "half of the current limit needs {} to the speed limit: the load is too heavy for this motor",
        "take the load off; else lower speed_limit_rad_s or take a larger motor",
        MS,
    ),
    f.FAULT_COMMISSION_PLAY: Words(
        "commissioning: play",
        "the joint has a play of {} against its rotor",
        "tighten the gear, the joint encoder's magnet and whatever is between them",
        DEGREE,
    ),
}


def fault_name(code: int) -> str:
    """Return the short name of a fault code."""
    return WORDS[code].name if code in WORDS else f"unknown fault {code}"


def fault_sentence(code: int, value: int, units: Units | None = None) -> str:
    """Return what happened with its number, and a hint, as one line."""
    if code not in WORDS:
        return f"unknown fault {code}: its value is {value}; update this program to the joint's version"
    words = WORDS[code]
    return f"{words.name}: {words.sentence.format(words.quantity.tell(value, units))}; {words.hint}"
