"""The simulated joint fails on command: the cause, which fault must latch, and how soon."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians

from shared.joint import faults as f
from shared.joint.commission_state import COMMISSION_VERIFY
from shared.wire import names as w

from ...robot.actuators import Bldc
from ...robot.joint_faults import fault_name, fault_sentence
from ...util.errors import UserError
from .bench import Bench
from .model import Load
from .result import Result
from .sensors import Wrong

SLIP_DEG = 7.0  # of the joint encoder's magnet: between the fault's 6.0 and the 8.18 of half a rotor turn


@dataclass(frozen=True)
class FaultCase:
    """A fault to switch on while the joint holds or moves; ``within_ms`` is how soon it must be latched."""

    code: int
    within_ms: int
    begin: Callable[[Bench], None]
    moving: bool = False
    run_ms: int = 400


def _sensed(wrong: Wrong) -> Callable[[Bench], None]:
    """Return what makes a bench's readings wrong."""

    def begin(b: Bench) -> None:
        b.wrong = b.sensors.wrong = replace(wrong)

    return begin


def _block(b: Bench) -> None:
    b.load.blocked = True
    b.goal += 0.4


def _late(b: Bench) -> None:
    b.late_every = 20


FAULTS: dict[str, FaultCase] = {
    "shunt-offset": FaultCase(f.FAULT_CURRENT_SENSE, 15, _sensed(Wrong(shunt_offset_counts=150.0))),
    "lost-encoder": FaultCase(f.FAULT_ENCODER_LOST, 5, _sensed(Wrong(rotor_lost=True)), moving=True),
    "encoder-disagreement": FaultCase(f.FAULT_ENCODER_DISAGREE, 10, _sensed(Wrong(joint_turned_rad=radians(SLIP_DEG)))),
    "open-thermistor": FaultCase(f.FAULT_THERMISTOR_OPEN, 110, _sensed(Wrong(thermistor="open")), run_ms=800),
    "short-thermistor": FaultCase(f.FAULT_THERMISTOR_SHORT, 110, _sensed(Wrong(thermistor="short")), run_ms=800),
    "bus-sag": FaultCase(f.FAULT_UNDER_VOLTAGE, 10, _sensed(Wrong(supply_V=15.0))),
    "stall": FaultCase(f.FAULT_STALL, 1200, _block, run_ms=2200),
    "late-interrupt": FaultCase(f.FAULT_OVERRUN, 110, _late, run_ms=800),
    "swapped-phases": FaultCase(f.FAULT_COMMISSION_PHASE_ORDER, 8000, _sensed(Wrong())),  # it is there from the start
}


def fault(bldc: Bldc, name: str) -> Result:
    """One fault of FAULTS: when it is latched, the joint's sentence, and the remaining torque."""
    case = FAULTS[name]
    if name == "swapped-phases":
        return _swapped(bldc, case)
    bench = Bench(bldc)
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.run(100)
    if case.moving:
        bench.goal += 0.3
        bench.run(40)
    if bench.state.fault_code:
        raise UserError(f"fault-{name}: the joint was already in fault: {_sentence(bench)}")
    case.begin(bench)
    found = _wait(bench, case.run_ms)
    bench.run(600)
    return _judged(name, case, bench, found)


def _swapped(bldc: Bldc, case: FaultCase) -> Result:
    """Two phases exchanged at a commissioned joint: verifying, with little current, finds it."""
    bench = Bench(bldc, Load(swapped_phases=True))
    bench.request(w.COMMAND_COMMISSION, COMMISSION_VERIFY)
    found = _wait(bench, case.within_ms)
    bench.run(600)
    return _judged("swapped-phases", case, bench, found)


def _wait(bench: Bench, milliseconds: int) -> int | None:
    for passed in range(1, milliseconds + 1):
        bench.run(1)
        if bench.state.fault_code:
            return passed
    return None


def _judged(name: str, case: FaultCase, bench: Bench, found: int | None) -> Result:
    state = bench.state
    torque = max(abs(x) for x in bench.trace.current_A[-20:]) * bench.units.newton_metre_per_cu
    torque /= bench.units.ampere_per_cu
    latched = state.fault_code == case.code and state.drive_state == w.STATE_FAULT and not bench.board.bridge
    figures = {
        "ok": bool(found is not None and found <= case.within_ms and latched and torque < 0.01),
        "fault": fault_name(state.fault_code),
        "message": _sentence(bench),
        "detected_after_ms": found,
        "torque_after_Nm": round(torque, 4),
        "within_ms": case.within_ms,
    }
    return Result(f"fault-{name}", figures, bench)


def _sentence(bench: Bench) -> str:
    return fault_sentence(bench.state.fault_code, bench.state.fault_value, bench.units)
