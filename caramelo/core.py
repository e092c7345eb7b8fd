"""The control core by itself, to study what it computes: integers, a tick at a time (docs/core.md).

Lengths are in the robot's own unit ``lu`` and angles in ``brad``, 1/65536 turn; ``scale_of`` and ``rad`` turn them into
metres and radians. ``Driver`` is the whole planner with SI on both sides.
"""

from host.boards.core import use_core

use_core()  # before anything of the core is imported

from host.control.planner import Driver  # noqa: E402
from host.robot.file import load_robot  # noqa: E402
from host.robot.scale import brad, core_params, rad, scale_of  # noqa: E402
from shared.body.feet import Feet  # noqa: E402
from shared.body.leg import leg_forward, leg_inverse  # noqa: E402
from shared.gait.swing import cycloid_q15, lift_q15, swing_phase_q16  # noqa: E402
from shared.runtime import zeros  # noqa: E402

__all__ = [
    "Driver",
    "Feet",
    "brad",
    "core_params",
    "cycloid_q15",
    "leg_forward",
    "leg_inverse",
    "lift_q15",
    "load_robot",
    "rad",
    "scale_of",
    "swing_phase_q16",
    "zeros",
]
