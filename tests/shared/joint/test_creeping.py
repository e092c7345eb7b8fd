"""Creeping for the cogging: weak waves under much friction, and the check of the waves by the speed's ripple."""

import math

import pytest

from shared.joint import commission_state as s
from shared.joint.creeping import creep_step

from .plant import Plant
from .test_commission import Cogging, finished


class Weak(Cogging):
    """A cogging of 0.1 % of the torque at the current limit: friction takes fifty times as much."""

    share = 0.001
    waves = ((42, share, 0.5),)


@pytest.mark.parametrize("direction", [1, -1])
def test_weak_cogging_is_found_under_fifty_times_its_friction(direction):
    """Within a fifth, so that at least four fifths of it are taken away."""
    plant = Weak(commissioned=False, direction=direction)
    torque_Nm = plant.bldc.motor.torque_constant_Nm_A * plant.bldc.drive.current_limit_A
    plant.friction = 50 * Weak.share * torque_Nm
    p = finished(plant)
    assert p.state.fault_code == 0
    limit = p.bldc.drive.current_limit_A / p.units.ampere_per_cu
    current, phase = p.settings.cogging_current_0 / 16, p.settings.cogging_phase_0 / 65536 * math.tau
    found = (current * math.cos(phase), current * math.sin(phase))
    wanted = Weak.share * limit * direction
    assert p.settings.cogging_order_0 == 42
    assert math.dist(found, (wanted * math.cos(0.5), wanted * math.sin(0.5))) < abs(wanted) / 5


def checked(orders):
    """Return a commissioning whose last round, with its waves, has found nothing but a speed above the wanted one."""
    p = Plant()
    c = p.commission
    c.phase, c.creep_part, c.creep_settled, c.pole_pairs, c.direction = s.PHASE_WAVES, 3, 0, 7, 1
    c.way, c.fold, c.order = 4000, 1, orders[0]
    for wave, order in enumerate(orders):
        c.wave_order[wave], c.wave_current[wave], c.ripple[wave] = order, 160, 50
    for place in range(s.COGS):
        c.cogging[place] = 1 << 20
    while not creep_step(p.loop, p.settings, p.state, p.io, c):
        assert c.phase == s.PHASE_WAVES
    return p


def test_a_dropped_first_wave_leaves_no_ripple_and_drops_no_other():
    """The mean speed is no ripple: taken for that of the first wave it was more than any other had."""
    p = checked((0, 42, 84))
    assert p.commission.ripple[0] == 0
    assert list(p.commission.wave_order) == [0, 42, 84]
