"""The crawl's settings: those found on Caramelo in proportion to the leg at any rate, and reach by the cosine rule."""

import math

import pytest

from host import crawl_tuning
from tests.float_twin import crawl_reach as twin

from .robots import CRAWL_GAINS, CRAWL_TICKS, KNEES, NAMES, block, crawl_si, leg_si

RATES = (20, 50, 333, 500)
LENGTHS = ("tall", "margin", "ahead", "com_z", "lift_front", "lift_rear", "near_print", "deepest", "hit", "high")
LENGTHS += ("advance", "advance_void", "back", "hit_back", "raised", "shin", "shin_raise", "too_high", "clear")
LENGTHS += ("void", "limit", "warp_max")
SPEEDS = ("body_v", "v_up", "v_top", "move_pace", "v_tare", "v_front", "v_rear", "v_slow", "v_quick", "warp", "warp_v")
ACCELERATIONS = ("a_up", "a_down", "brake")


def settings(name, rate_hz, knees="full-elbow"):
    """Return a robot's crawl in SI, and its unit in m and leg in m."""
    params = block(name, rate_hz, knees)
    unit_m = 2.0 ** -params.length_shift
    return crawl_si(params), unit_m, params.leg_length * unit_m


@pytest.mark.parametrize("rate_hz", RATES)
@pytest.mark.parametrize("name", NAMES)
def test_every_robot_crawls_as_caramelo_in_proportion_to_its_leg_at_every_rate(name, rate_hz):
    found, unit_m, leg_m = settings(name, rate_hz)
    first, first_unit_m, first_leg_m = settings("caramelo", 500)
    size, fine_m = leg_m / first_leg_m, unit_m / 256
    for length in LENGTHS:
        rounding = 2 * unit_m + size * first_unit_m
        assert getattr(found, length) == pytest.approx(size * getattr(first, length), abs=rounding), length
    for power, names in ((1, SPEEDS), (2, ACCELERATIONS)):
        for what in names:
            rounding = 2 * fine_m * rate_hz**power + 2 * size * first_unit_m / 256 * 500**power
            exact = size * getattr(first, what) * 500**power
            assert getattr(found, what) * rate_hz**power == pytest.approx(exact, abs=rounding), what
    for time in CRAWL_TICKS:
        seconds = getattr(first, time) / 500
        rounding = max(0.5, 1 - seconds * rate_hz)  # at least one tick
        assert getattr(found, time) == pytest.approx(seconds * rate_hz, abs=rounding), time
    for gain in CRAWL_GAINS:
        exact = min(1.0, getattr(first, gain) * 500 / rate_hz)
        assert getattr(found, gain) == pytest.approx(exact, abs=1 / 32768 + exact / 60), gain


@pytest.mark.parametrize("knees", KNEES)
@pytest.mark.parametrize("name", NAMES)
def test_reach_height_and_stride_follow_from_the_shape(name, knees):
    found, unit_m, _ = settings(name, 50, knees)
    legs = [leg_si(block(name, 50, knees), leg) for leg in range(4)]
    for what, exact in twin.shape(legs).items():
        assert getattr(found, what) == pytest.approx(exact, abs=8 * unit_m), what


@pytest.mark.parametrize("name", NAMES)
def test_legs_reach_no_farther_than_the_calves_bend(name):
    """Hip to foot: the leg in its plane and the hip's offset are the two sides of a right angle."""
    params = block(name)
    unit_m = 2.0 ** -params.length_shift
    for leg in range(4):
        shape, limb = leg_si(params, leg), params.legs[leg]
        far, near = [math.hypot(length, shape.l1) for length in twin.leg_lengths(shape)]
        far = min(far, math.hypot(shape.l1, shape.l2 + shape.l3))
        near = max(near, math.hypot(shape.l1, shape.l2 - shape.l3))
        assert limb.longest * unit_m == pytest.approx(far, abs=6 * unit_m)
        assert limb.shortest * unit_m == pytest.approx(near, abs=6 * unit_m)
        assert limb.clearance * unit_m == pytest.approx(-(near + shape.l1) / 2, abs=6 * unit_m)


# From docs/gaits.md and the texts of the core, m and s
CARAMELO = {"margin": 0.028, "lift_front": 0.065, "lift_rear": 0.035, "high": 0.018, "void": 0.024, "deepest": 0.085}
CARAMELO_S = {"touch_ticks": 0.06, "tare_ticks": 0.14, "warp_ticks": 1.5, "share_ticks": 0.3, "settle": 0.06}


def caramelos_are_those_of_the_texts():
    found, unit_m, _ = settings("caramelo", 50)
    for what, metres in CARAMELO.items():
        assert getattr(found, what) == pytest.approx(metres, abs=2 * unit_m), what
    for what, seconds in CARAMELO_S.items():
        assert getattr(found, what) == round(seconds * 50), what
    assert found.v_up * 50 == pytest.approx(0.24, rel=1e-3)
    assert found.brake * 2500 / 2 == pytest.approx(2.5, rel=1e-3)


def test_caramelos_settings_are_those_of_the_texts(monkeypatch):
    """And the check can fail: lengths that belong to a leg of 250 mm."""
    caramelos_are_those_of_the_texts()
    monkeypatch.setattr(crawl_tuning, "_LEG_MM", 250)
    with pytest.raises(AssertionError, match="margin"):
        caramelos_are_those_of_the_texts()
