"""Servos drawn at random and told to nobody are found again, over their own protocol; broken ones are named."""

from random import Random

import pytest

from host.bus.base import JOINT_LABELS
from host.bus.dynamixel.link import ServoError
from host.identify.carried import in_the_air
from host.identify.fit import JointFit
from host.identify.sweeping import sweep_joint
from host.identify.verdict import LOOSE, REVERSED, SOUND, STICKING, STIFF, judge, sticking, told_of, weight_is
from host.sim.servos.honest import FAULTS, reference_shaft_rad

from .robots import COMPARED, ROBOT, SERVO, errors, measured, stand

WITHIN, WITHIN_MS = 0.10, 2.0
ONE = 116  # of its joints a calf is measured: the least weight on it, so the hardest; quickly fitted
FORTY = [seed if seed == ONE else pytest.param(seed, marks=pytest.mark.slow) for seed in range(100, 140)]


@pytest.mark.parametrize("seed", FORTY)
def test_robots_are_found_again(seed):
    joint = seed % 12
    made, fitted, (found, real) = measured(seed, joint)
    off = errors(made, joint, fitted)
    bad = {name: f"{100 * off[name]:+.0f} %" for name in COMPARED if abs(off[name]) > WITHIN}
    if abs(off["delay_ms"]) > WITHIN_MS:
        bad["delay"] = f"{off['delay_ms']:+.1f} ms"
    if abs(found / real - 1) > WITHIN:
        bad["supply"] = f"{100 * (found / real - 1):+.0f} %"
    assert bad == {}


def kind_of(made, joint):
    """Return what is said of a joint by its weight; None if it does not even get to its place."""
    try:
        traces = sweep_joint(made.rig, joint)
    except ServoError as error:
        if JOINT_LABELS[joint] in str(error) and "calibration" in str(error):
            return None, []
        raise
    mirror_rad = reference_shaft_rad(ROBOT, joint)
    return weight_is(SERVO, in_the_air(ROBOT, joint), traces, mirror_rad), traces


@pytest.mark.slow
@pytest.mark.parametrize("number", range(20))
def test_a_broken_joint_is_named(number):
    chance, fault = Random(f"broken {number}"), FAULTS[number % len(FAULTS)]
    joint = chance.randrange(12)
    made = stand(200 + number, fault, joint)
    kind, traces = kind_of(made, joint)
    if fault in (LOOSE, REVERSED):
        assert kind == fault or (kind is None and fault == REVERSED and joint % 3 == 1)
        return
    assert kind == SOUND
    fits = {}
    for other in [at for at in range(joint % 3, 12, 3) if at != joint][:2]:
        its_kind, its_traces = kind_of(made, other)
        assert its_kind == SOUND
        fits[other] = JointFit(SERVO, in_the_air(ROBOT, other), its_traces).run()
    usual = {name: sum(fit.values[name] for fit in fits.values()) / len(fits) for name in fits[other].values}
    stick = sticking(SERVO, in_the_air(ROBOT, joint), traces, usual)
    fits[joint] = JointFit(SERVO, in_the_air(ROBOT, joint), traces).run()
    assert judge(joint, fits, stick).kind == {"sticking": STICKING, "double friction": STIFF}[fault], told_of(usual)
