"""All joints together show how the supply sags, which a single joint hardly does."""

import pytest

from host.identify.sweeping import shake_all
from host.identify.together import supply_ohm

from .robots import LOADS, SERVO, all_drawn, stand


@pytest.mark.parametrize("seed", [107, 108, 131])
def test_shaking_tells_the_supplys_resistance(seed):
    made = stand(seed)
    rows = shake_all(made.rig)
    assert supply_ohm(SERVO, LOADS, all_drawn(made), rows) == pytest.approx(made.plant.made.supply_ohm, rel=0.10)
