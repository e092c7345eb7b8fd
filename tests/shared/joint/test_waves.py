"""Creeping for the cogging: weak waves under much friction, and the check of the waves by the speed's ripple."""

import math

import pytest

from shared.joint import commission_state as s
from shared.joint.waves import creep_step

from .plant import Plant
from .test_commission import Cogging, finished, off_wave


class Weak(Cogging):
    """A cogging of 0.1 % of the torque at the current limit: friction takes fifty times as much."""

    share = 0.001
    waves = ((42, share, 0.5),)


def test_weak_cogging_is_found_under_fifty_times_its_friction():
    """Within a fifth, so that at least four fifths of it are taken away."""
    plant = Weak(commissioned=False, direction=-1)
    torque_Nm = plant.bldc.motor.torque_constant_Nm_A * plant.bldc.drive.current_limit_A
    plant.friction = 50 * Weak.share * torque_Nm
    p = finished(plant)
    assert p.state.fault_code == 0
    assert p.settings.cogging_order_0 == 42
    assert off_wave(p, *Weak.waves[0]) < Weak.share / 5


def looked(part, orders, wave_in_table=0, settled=0):
    """Return a plant after a round of that part, whose table holds one wave or, 0, a speed above the wanted one."""
    p = Plant()
    c = p.commission
    c.phase, c.creep_part, c.creep_settled, c.pole_pairs, c.direction = s.PHASE_WAVES, part, settled, 7, 1
    c.way, c.table_repeats, c.order, c.order_last = 32000, 1, orders[0], orders[0]
    for wave, order in enumerate(orders[-3:]):
        c.wave_order[wave], c.wave_current[wave], c.ripple[wave] = order, 160, 50
    for place in range(s.COGGING_BINS):
        c.cogging_bins[place] = round(math.cos((place + 0.5) * wave_in_table / s.COGGING_BINS * math.tau) * (1 << 20))
    for _ in range(3 * s.COGGING_BINS):
        if creep_step(p.loop, p.settings, p.state, p.io, c) or c.phase != s.PHASE_WAVES or c.creep_part != part:
            break
    return p.commission


def test_a_dropped_first_wave_leaves_no_ripple_and_drops_no_other():
    """The mean speed is no ripple: taken for that of the first wave it was more than any other had."""
    c = looked(3, (0, 42, 84))
    assert c.ripple[0] == 0
    assert list(c.wave_order) == [0, 42, 84]


@pytest.mark.parametrize(("there", "quiet"), [(42, 0b110), (84, 0)])
def test_a_wave_that_shakes_less_than_its_current_would_is_not_there(there, quiet):
    """42 is the first of three waves of the same current; without them the rotor's speed has one ripple."""
    c = looked(2, (42, 60, 84), there, settled=1)
    assert (c.creep_part, c.rejected_waves) == (3, quiet)


@pytest.mark.parametrize(("order", "taken"), [(39, False), (37, True)])
def test_a_wave_that_the_check_cannot_tell_from_the_first_is_not_taken(order, taken):
    c = looked(1, (order, 42, 0, 0), order, settled=1)
    assert (order in c.wave_order) == taken
    assert c.wave_order[0] == 42
