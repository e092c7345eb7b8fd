"""What the fit takes for a measurement, and what for rounding."""

import numpy as np

from host.identify.fit import STILL, beyond_step, moves
from host.identify.sweeping import Trace

STANDS, TURNS = 40, 30


def test_a_joint_moves_from_shortly_before_its_first_step_to_shortly_after_its_last():
    places = [0.1] * STANDS + [0.1 + 0.0015 * (k // 3) for k in range(3, TURNS + 3)] + [0.2] * STANDS
    moving = moves(Trace(0, "slow", position_rad=places))
    first, last = STANDS, STANDS + TURNS
    assert list(np.flatnonzero(moving)) == list(range(first - STILL, last + STILL))


def test_a_difference_within_a_step_is_rounding():
    assert list(beyond_step(np.array([-0.75, -0.5, 0.0, 0.3, 1.5]))) == [-0.25, 0.0, 0.0, 0.0, 1.0]
