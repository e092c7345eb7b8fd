"""The scenarios of `caramelo motor sim`, by name: a motion, a loop, a fault or the commissioning of a joint."""

from collections.abc import Callable
from functools import partial

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
    **{f"fault-{name}": partial(fault, name=name) for name in FAULTS},
}


def chosen(name: str | None) -> list[str]:
    """Return the scenario of that name alone, all for None; UserError with the list for an unknown one."""
    if name is None:
        return list(SCENARIOS)
    if name not in SCENARIOS:
        raise UserError(f"--scenario {name}: allowed {', '.join(SCENARIOS)}")
    return [name]


def run_scenario(bldc: Bldc, name: str) -> Result:
    """Run one of SCENARIOS."""
    return SCENARIOS[name](bldc)
