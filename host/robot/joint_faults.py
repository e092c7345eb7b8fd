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
    """How to print a value: SI unit and factor if that needs the joint's Units, else its own unit."""

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
    """``sentence`` says what happened, with {} for the value and its unit; ``hint`` says what to do."""

    name: str
    quantity: Quantity
    sentence: str
    hint: str


WORDS: dict[int, Words] = {
    f.FAULT_NONE: Words("none", PLAIN, "no fault",
        "nothing to do"),
    f.FAULT_WATCHDOG: Words("watchdog", MS, "no set-point came for {}",
        "the host stopped sending or the bus is broken; clear and arm again"),
    f.FAULT_OVER_SPEED: Words("over-speed", RAD_S, "the joint turned at {}",
        "lower the commanded speed, or look for something that pushes the joint"),
    f.FAULT_POSITION_LIMIT: Words("position limit", DEGREE, "the joint moved out to {}",
        "move the joint back by hand; check its limits and zero"),
    f.FAULT_STALL: Words("stall", AMPERE, "the joint pushed with {} without moving",
        "free the joint; if it is free, check the motor's three wires and their order, then commission it"),
    f.FAULT_WINDING_HOT: Words("winding hot", CELSIUS, "the winding is at {}",
        "let it cool; lower the load or improve the cooling"),
    f.FAULT_MCU_HOT: Words("board hot", CELSIUS, "the microcontroller is at {}",
        "let it cool; give the board air"),
    f.FAULT_THERMISTOR_OPEN: Words("thermistor open", COUNTS, "the thermistor reads {}",
        "check its wire and connector"),
    f.FAULT_THERMISTOR_SHORT: Words("thermistor short", COUNTS, "the thermistor reads {}",
        "look for a short circuit in its wire"),
    f.FAULT_DUPLICATE_ID: Words("duplicate id", PLAIN, "another joint sends as node {}",
        "give one of them another id with caramelo joints set-id"),
    f.FAULT_OVERRUN: Words("overrun", PLAIN, "{} current steps came late",
        "report it with the log; lower the current loop's rate"),
    f.FAULT_MCU_SENSOR: Words("board sensor", COUNTS, "the temperature sensor of the microcontroller reads {}",
        "the board is defective"),
    f.FAULT_JOINT_ENCODER_LOST: Words("joint encoder lost", MS, "no valid reading of the joint encoder for {}",
        "check the encoder's connector and the distance of its magnet"),
    f.FAULT_EMERGENCY_STOP: Words("emergency stop", PLAIN, "an emergency stop was commanded",
        "release it, then clear and arm again"),
    f.FAULT_OVER_CURRENT: Words("over-current", AMPERE, "the current reached {}",
        "look for a short circuit between the phases; check the motor's wires and their order, then commission it"),
    f.FAULT_UNDER_VOLTAGE: Words("under-voltage", VOLT, "the supply fell to {}",
        "charge the battery; check the supply's wires"),
    f.FAULT_OVER_VOLTAGE: Words("over-voltage", VOLT, "the supply rose to {}",
        "braking feeds current back into the supply: brake more slowly, or use a battery"),
    f.FAULT_ENCODER_LOST: Words("encoder lost", PLAIN,
        "{} readings of the rotor encoder were rejected in one millisecond",
        "check the encoder's connector and the distance of its magnet"),
    f.FAULT_ENCODER_DISAGREE: Words("encoder disagreement", DEGREE, "joint and rotor encoder differ by {}",
        "check coupling and magnets, then home the joint again; commission it again if a part was changed"),
    f.FAULT_CURRENT_SENSE: Words("current sensing", COUNTS, "the three phase currents add up to {} instead of 0",
        "commission it again; if it returns, a shunt or its amplifier is defective"),
    f.FAULT_DRIVER: Words("gate driver", PLAIN, "the gate driver reports {} in its fault registers",
        "look up the bits in docs/joint.md; often it is a short circuit at the motor"),
    f.FAULT_DRIVER_SETUP: Words("gate driver setup", PLAIN,
        "register {} of the gate driver does not read back as written, or the hardware left its ready state",
        "switch the power off and on; if it returns, the board is defective"),
    f.FAULT_EXCEPTION: Words("exception", PLAIN,
        "the program failed in part {} (1 current step, 2 motion, 3 slow, 4 bus)",
        "report it with the log"),
    f.FAULT_POSITION_RANGE: Words("position range", PLAIN,
        "the rotor is {} turns from zero, more than a position value can hold",
        "home the joint again"),
    f.FAULT_STORAGE: Words("storage", PLAIN, "the stored parameters could not be read",
        "write and save the parameters again"),
    f.FAULT_INTERRUPT_STOPPED: Words("interrupt stopped", MS, "no current step for {}",
        "reset the board; report it with the log"),
    f.FAULT_COMMISSION_OFFSET: Words("commissioning: offset", COUNTS,
        "a current sensor reads {} without current, instead of 2048",
        "a shunt amplifier is defective"),
    f.FAULT_COMMISSION_NOISE: Words("commissioning: noise", COUNTS, "a current sensor's noise is {}",
        "look for a loose wire or a switching supply nearby"),
    f.FAULT_COMMISSION_SUM: Words("commissioning: sum", COUNTS, "while current flows, the three phases add up to {}",
        "a shunt amplifier or its gain is wrong"),
    f.FAULT_COMMISSION_BUS: Words("commissioning: supply", VOLT, "the supply is at {}",
        "connect the right supply"),
    f.FAULT_COMMISSION_ENCODER: Words("commissioning: encoder", COUNTS, "the rotor encoder wanders by {} at rest",
        "check its magnet"),
    f.FAULT_COMMISSION_NO_CURRENT: Words("commissioning: no current", AMPERE, "a current of only {} flowed",
        "connect the motor: two or all of its wires are open, or the supply is too weak"),
    f.FAULT_COMMISSION_NOT_FREE: Words("commissioning: not free", COUNTS,
        "the rotor moved {} instead of following the field",
        "free the joint; lift the robot"),
    f.FAULT_COMMISSION_POLE_PAIRS: Words("commissioning: pole pairs", COUNTS,
        "the rotor moved {} while the field turned, which fits no whole number of pole pairs",
        "free the joint; check that the rotor encoder's magnet does not slip"),
    f.FAULT_COMMISSION_PHASE_ORDER: Words("commissioning: phase order", PLAIN,
        "the rotor turns in direction {}, opposite to the stored one",
        "two motor wires are swapped: swap them back, or commission the joint again"),
    f.FAULT_COMMISSION_FRICTION: Words("commissioning: friction", ELECTRICAL,
        "friction holds the rotor {} behind the field",
        "free the joint; if it is free, raise current_limit_A: half of it turns the rotor"),
    f.FAULT_COMMISSION_JOINT_ENCODER: Words("commissioning: joint encoder", COUNTS,
        "the joint encoder moved {} while the rotor turned",
        "check its magnet and coupling"),
    f.FAULT_COMMISSION_MOVING: Words("commissioning: moving", RAD_S, "the joint turns at {}",
        "hold the joint still"),
    f.FAULT_COMMISSION_OFFSET_CHANGED: Words("commissioning: offset changed", ELECTRICAL,
        "the rotor offset differs from the stored one by {}",
        "the magnet has slipped: commission the joint again"),
    f.FAULT_HOME_NO_STOP: Words("homing: no stop", MS, "no stop was found within {}",
        "check the direction of the search, and the joint's stop"),
    f.FAULT_HOME_AMBIGUOUS: Words("homing: ambiguous", DEGREE, "the stop found at {} does not fit the rotor's angle",
        "check what stopped the joint, and its parameter stop, the stop's position"),
    f.FAULT_COMMISSION_PHASE_OPEN: Words("commissioning: phase open", PLAIN, "phase {} of 3 carries no current",
        "check this motor wire, its plug and its winding"),
    f.FAULT_COMMISSION_WINDING: Words("commissioning: winding", PLAIN,
        "the resistance or inductance would need a current loop gain of {}, which is out of range",
        "look for a short circuit in the winding; else change current_bandwidth_hz"),
    f.FAULT_COMMISSION_END_STOP: Words("commissioning: end stop", COUNTS,
        "the rotor stopped after {} and did not go round",
        "move the joint to the middle of its range: the rotor needs one turn either way"),
    f.FAULT_COMMISSION_MAGNET: Words("commissioning: magnet", COUNTS,
        "the rotor encoder's readings are off by up to {} either way",
        "centre its magnet on the shaft"),
    f.FAULT_COMMISSION_FLUX: Words("commissioning: flux", PLAIN,
        "the measured back-EMF is {}, which no motor for this supply has",
        "check the rotor's magnets and the supply's voltage"),
    f.FAULT_COMMISSION_INERTIA: Words("commissioning: inertia", PLAIN,
        "the measured inertia is {}, for which no gain of the velocity loop fits",
        "check that the joint swings freely; else change velocity_bandwidth_hz"),
    f.FAULT_COMMISSION_COGGING: Words("commissioning: cogging", AMPERE,
        "the rotor's cogging takes {}, more than the joint can compensate",
        "check that nothing rubs once or more per turn; else this motor's cogging is too strong for its current limit"),
    f.FAULT_COMMISSION_CURRENT_LOOP: Words("commissioning: current loop", PERCENT,
        "the current loop has {} of the wanted bandwidth",
        "commission it again; if it returns, the winding is not linear: change current_bandwidth_hz"),
    f.FAULT_COMMISSION_VELOCITY_LOOP: Words("commissioning: velocity loop", PERCENT,
        "the velocity loop has {} of the wanted bandwidth",
        "check that the joint carries and touches nothing; else change velocity_bandwidth_hz"),
    f.FAULT_COMMISSION_POSITION_LOOP: Words("commissioning: position loop", PERCENT,
        "the position loop has {} of the wanted bandwidth",
        "check that the joint touches nothing; else change position_bandwidth_hz"),
    f.FAULT_COMMISSION_LOAD: Words("commissioning: load", MS,
        "half of the current limit takes {} to reach the speed limit: the load is too heavy for this motor",
        "take the load off; else lower speed_limit_rad_s or use a larger motor"),
    f.FAULT_COMMISSION_PLAY: Words("commissioning: play", DEGREE, "the joint has a play of {} against its rotor",
        "tighten the gear, the joint encoder's magnet and whatever is between them"),
}  # fmt: skip


def fault_name(code: int) -> str:
    """Return the short name of a fault code."""
    return WORDS[code].name if code in WORDS else f"unknown fault {code}"


def fault_sentence(code: int, value: int, units: Units | None = None) -> str:
    """Return in one line what happened, its value, and a hint."""
    if code not in WORDS:
        return f"unknown fault {code}: its value is {value}; update this program to the joint's version"
    words = WORDS[code]
    return f"{words.name}: {words.sentence.format(words.quantity.tell(value, units))}; {words.hint}"
