"""The control core by itself, for looking at what it computes: integers, a tick at a time (docs/core.md).

Lengths are in the robot's own unit ``lu`` and angles in ``brad``, 1/65536 turn; ``scale_of`` and ``rad`` turn them into
metres and radians. ``Driver`` is the whole planner with SI on both sides.
"""

from host.control.planner import Driver
from host.robot.file import load_robot
from host.robot.scale import brad, core_params, rad, scale_of
from shared.body.leg import leg_forward, leg_inverse
from shared.gait.swing import cycloid_q15, lift_q15, swing_phase_q16
from shared.runtime import zeros

__all__ = [
    "Driver",
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
