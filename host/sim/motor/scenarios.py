"""The scenarios of `caramelo motor sim`, by name: a motion, a loop, a fault or the commissioning of a joint."""

from collections.abc import Callable

from ...robot.actuators import Bldc
from ...util.errors import UserError
from .commission import commission
from .currents import closed_loop, current_held, current_locked, stall
from .faults import FAULTS, fault
from .motions import glitches, sine, step
from .result import Result

SCENARIOS: dict[str, Callable[[Bldc], Result]] = {
    "step": step,
    "sine": sine,
    "glitches": glitches,
    "stall": stall,
    "current-locked": current_locked,
    "current-held": current_held,
    "closed-loop": closed_loop,
    "commission": commission,
}


def names() -> list[str]:
    """Return all scenarios in order."""
    return [*SCENARIOS, *(f"fault-{name}" for name in FAULTS)]


def chosen(name: str | None) -> list[str]:
    """Return the scenario of that name alone, all for None; UserError with the list for an unknown one."""
    if name is None:
        return names()
    if name not in names():
        raise UserError(f"--scenario {name}: allowed {', '.join(names())}")
    return [name]


def run_scenario(bldc: Bldc, name: str) -> Result:
    """Run one of ``names()``."""
    return SCENARIOS[name](bldc) if name in SCENARIOS else fault(bldc, name.removeprefix("fault-"))
