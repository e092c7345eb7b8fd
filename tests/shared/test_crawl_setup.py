"""The crawl's settings: those found on Caramelo in proportion to the leg at any rate, and reach by the cosine rule."""

import math

import pytest

from host.robot import crawl_tuning
from host.robot.drives import joint_drives
from host.robot.file import load_robot
from host.robot.scale import brad, core_params
from shared.body.crawl_setup import CrawlSetup
from shared.record import pack
from tests.float_twin import crawl_reach as twin
from tests.float_twin.reach import leg_lengths
from tests.float_twin.si import leg_si

from .robots import KNEES, NAMES, block, crawl_si, robot

RATES = (20, 50, 333, 500)
# What is tuned, by the core's unit; the rest follows from the shape
TUNED = {unit: [name for name, place in CrawlSetup.FIELDS if place.unit == unit and place.default]
         for unit in ("lu", "lf / tick", "lf / tick^2", "ticks", "Q15 / tick")}
TUNED["lf / tick"].remove("quick_lower_speed")  # has a test of its own


def settings(name, rate_hz, knees="full-elbow"):
    """Return a robot's crawl in SI, and its unit in m and leg in m."""
    params = core_params(robot(name, knees), rate_hz)
    unit_m = 2.0 ** -params.length_shift
    return crawl_si(params), unit_m, params.leg_length * unit_m


def calm(name, height_m):
    """Return the share of the pose loop's gains: the sway's damping of three legs, per 10 / s, at most 1."""
    made = robot(name)
    return min(1.0, 3 * joint_drives(made)[1].damping_Nms_rad / (made.mass_kg * height_m**2) / 10.0)


def test_the_longer_a_robot_sways_the_less_its_pose_loop_corrects():
    """Caramelo and Parallel take the table's gains; a leg of 1 m, of which Parallel's drives damp little, a tenth."""
    shares = {name: core_params(robot(name), 50).crawl.error_q15 / (0.3 * 32768) for name in NAMES}
    assert (shares["caramelo"], shares["parallel"]) == pytest.approx((1.0, 1.0), abs=1e-4)
    for name in NAMES:
        assert shares[name] == pytest.approx(calm(name, settings(name, 50)[0].height), abs=1e-3), name
    assert shares["long-leg"] < 0.15


def test_the_less_the_joints_rub_the_less_load_makes_a_contact():
    """Caramelo takes the table's 2 and 2.7 N of its 21.6 N; others from half to one and a half of these shares."""
    for name in NAMES:
        made, found = robot(name), core_params(robot(name), 50).crawl
        rubs_Nm = sum(joint.coulomb_Nm for joint in joint_drives(made)[1:3]) / 2
        share = min(1.5, max(0.5, rubs_Nm / (made.mass_kg * 9.81 * made.geometry.leg_m / 2) / 0.0219))
        assert (found.touch_q12, found.peak_q12) == pytest.approx((share * 379, share * 512), abs=1.5), name
    assert core_params(robot("caramelo"), 50).crawl.touch_q12 == pytest.approx(379, abs=1)
    assert core_params(robot("parallel"), 50).crawl.touch_q12 == pytest.approx(379 / 2, abs=1)


def lean_share(made, height_m):
    """Return by how much feet come down slower so that the body leans aside by 0.04 of the leg over one, at most."""
    leg_m, width_m = made.geometry.leg_m, 2 * (made.hip_m(1)[1] + made.geometry.hip_offset_m)
    knee_m = (leg_m**2 - height_m**2) ** 0.5 / 2  # beside the line from hip to foot
    gives_m = made.mass_kg * 9.81 / 2 * knee_m**2 / joint_drives(made)[2].stiffness_Nm_rad
    return min(1.0, (gives_m + 0.04 * leg_m * width_m / height_m) / (0.06 * (0.1 + 0.06) * leg_m / 0.24))


def test_a_foot_comes_down_no_faster_than_its_push_and_the_bodys_lean_allow():
    """On even ground 0.7 of the weight at a step, on its way on for 60 ms, and slowly for 60 more."""
    shares = []
    for made in (*map(robot, NAMES), load_robot("pupper")):
        k = core_params(made, 500).crawl
        m_s = 2.0 ** -core_params(made, 500).length_shift / 256 * 500
        share, leg = lean_share(made, k.height * m_s * 256 / 500), made.geometry.leg_m / 0.24
        deep_m = 0.7 * made.mass_kg * 9.81 / (joint_drives(made)[1].stiffness_Nm_rad / (made.geometry.leg_m / 2) ** 2)
        most = (deep_m - 0.06 * leg * k.contact_ticks / 500) / (k.goal_lag_ticks / 500)
        quick = max(0.1 * leg, min(0.192 * leg, most))
        found = [k.loaded_lower_speed, k.unknown_lower_speed, k.known_lower_speed, k.quick_lower_speed]
        wanted = [share * speed for speed in (0.06 * leg, 0.1 * leg, 0.192 * leg, quick)]
        assert [speed * m_s for speed in found] == pytest.approx(wanted, rel=0.01), made.name
        shares.append(share)
    assert min(shares) < 0.9 < max(shares) == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_the_zero_moment_point_stays_as_far_inside_as_caramelos(name):
    """It is off by acceleration times height over gravity; the margin goes with the leg."""
    found, unit_m, leg_m = settings(name, 50)
    crawl = core_params(robot(name), 50).crawl
    for field, off_m in (("body_acceleration", 0.6 * 0.185 / 9.81), ("quick_body_acceleration", 1.25 * 0.185 / 9.81)):
        off_by_leg = getattr(crawl, field) * unit_m * found.height / 9.81 / leg_m
        assert off_by_leg == pytest.approx(off_m / 0.24, rel=2e-3), field


@pytest.mark.parametrize("rate_hz", RATES)
@pytest.mark.parametrize("name", NAMES)
def test_every_robot_crawls_as_caramelo_in_proportion_to_its_leg_at_every_rate(name, rate_hz):
    found, unit_m, leg_m = settings(name, rate_hz)
    first, first_unit_m, first_leg_m = settings("caramelo", 500)
    size, fine_m = leg_m / first_leg_m, unit_m / 256
    for length in TUNED["lu"]:
        rounding = 2 * unit_m + size * first_unit_m
        assert getattr(found, length) == pytest.approx(size * getattr(first, length), abs=rounding), length
    for power, names in ((1, TUNED["lf / tick"]), (2, TUNED["lf / tick^2"])):
        for what in names:
            rounding = 2 * fine_m * rate_hz**power + 2 * size * first_unit_m / 256 * 500**power
            exact = size * getattr(first, what) * 500**power
            assert getattr(found, what) * rate_hz**power == pytest.approx(exact, abs=rounding), what
    for time in TUNED["ticks"]:
        seconds = getattr(first, time) / 500
        rounding = max(0.5, 1 - seconds * rate_hz)  # at least one tick
        assert getattr(found, time) == pytest.approx(seconds * rate_hz, abs=rounding), time
    for gain in TUNED["Q15 / tick"]:
        exact = min(1.0, getattr(first, gain) * 500 / rate_hz)
        exact *= calm(name, found.height) if gain == "integral_q15" else 1.0
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
        far, near = [math.hypot(length, shape.l1) for length in leg_lengths(shape)]
        far = min(far, math.hypot(shape.l1, shape.l2 + shape.l3))
        near = max(near, math.hypot(shape.l1, shape.l2 - shape.l3))
        assert limb.longest * unit_m == pytest.approx(far, abs=6 * unit_m)
        assert limb.shortest * unit_m == pytest.approx(near, abs=6 * unit_m)
        assert limb.clearance * unit_m == pytest.approx(-(near + shape.l1) / 2, abs=6 * unit_m)


GIVEN = {
    "margin_m": ("margin", 0.02, 1),
    "com_z_m": ("com_z", -0.012, 1),
    "lift_speed_m_s": ("lift_speed", 0.2, 256 / 50),
    "lift_acceleration_m_s2": ("lift_acceleration", 2.5, 256 / 2500),
    "body_acceleration_m_s2": ("body_acceleration", 0.5, 1),
}


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_a_robot_file_may_give_the_crawls_numbers_anew(name):
    """In SI, of its own leg; what it does not name stays as it is."""
    values = {key: value for key, (_, value, _) in GIVEN.items()}
    other = {"settle_s": 0.08, "tare_in_s": 0.1, "angle_limit_rad": 0.15, "touch_weights": 0.2, "error": 0.25}
    changed = core_params(robot(name).model_copy(update={"crawl": values | other}), 50)
    usual, unit_m = block(name), 2.0**-changed.length_shift
    for field, value, unit in GIVEN.values():
        assert getattr(changed.crawl, field) * unit_m == pytest.approx(value * unit, abs=2 * unit_m * (1 + unit)), field
    assert (changed.crawl.settle_ticks, changed.crawl.angle_limit) == (4, brad(0.15))
    assert changed.crawl.tare_in_q15 == round(32768 / 0.1 / 50)
    assert (changed.crawl.touch_q12, changed.crawl.error_q15) == (round(4096 * 0.2), 8192)
    for field, _, _ in GIVEN.values():
        setattr(changed.crawl, field, getattr(usual.crawl, field))
    for field in ("settle_ticks", "angle_limit", "tare_in_q15", "touch_q12", "error_q15"):
        setattr(changed.crawl, field, getattr(usual.crawl, field))
    assert pack(changed) == pack(usual)


# From docs/gaits.md and the texts of the core, m and s
CARAMELO = {
    "margin": 0.028, "front_lift": 0.065, "hind_lift": 0.035, "edge_height": 0.018, "drop_depth": 0.024,
    "deepest": 0.085,
}  # fmt: skip
CARAMELO_S = {
    "contact_ticks": 0.06, "hang_ticks": 0.1, "diagonal_ticks": 1.5, "share_ticks": 0.3, "settle_ticks": 0.04,
}  # fmt: skip


def caramelos_are_those_of_the_texts():
    found, unit_m, _ = settings("caramelo", 50)
    for what, metres in CARAMELO.items():
        assert getattr(found, what) == pytest.approx(metres, abs=2 * unit_m), what
    for what, seconds in CARAMELO_S.items():
        assert getattr(found, what) == round(seconds * 50), what
    assert found.lift_speed * 50 == pytest.approx(0.24, rel=1e-3)
    assert found.lift_brake * 2500 / 2 == pytest.approx(2.5, rel=1e-3)


def test_caramelos_settings_are_those_of_the_texts(monkeypatch):
    """And the check can fail: lengths that belong to a leg of 250 mm."""
    caramelos_are_those_of_the_texts()
    monkeypatch.setattr(crawl_tuning, "_LEG_MM", 250)
    with pytest.raises(AssertionError, match="margin"):
        caramelos_are_those_of_the_texts()
