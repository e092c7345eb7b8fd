"""The crawl's machine against its float twin over whole walks: the same stage of the same leg at the same tick.

A tick may differ only where a value lies within rounding of its threshold (see float_twin/doubt.py).
"""

import random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from shared.crawl import steps as crawl_steps
from tests.float_twin import crawl_machine as twin

from .crawl_pair import Pair, Trouble

ROBOTS = [("caramelo", 50), ("caramelo", 20), ("parallel", 100), ("long-leg", 50), ("unequal", 200)]
STEPS = st.lists(
    st.tuples(st.floats(0.05, 0.3), st.one_of(st.floats(-0.06, 0.06), st.floats(-0.12, 0.12))), max_size=3
)
TROUBLES = st.builds(
    Trouble,
    steps=STEPS,
    slope=st.sampled_from((0.0, 0.0, -0.15, -0.02, 0.03, 0.15)),
    tare=st.floats(-0.1, 0.15),
    noise=st.sampled_from((0.0, 1.0)),
    skew=st.floats(-1.6, 1.6),
    sticks=st.booleans(),
    heavy=st.sampled_from((0.0, 0.0, 0.5, 1.0)),
    calves=st.sampled_from((0.0, 0.0, 0.4)),
    straight=st.sampled_from((0.0, 0.4)),
    sinks=st.sampled_from((0.0, 0.0, 0.2)),
    clipped=st.sampled_from((0.0, 0.1)),
    pauses=st.sampled_from((0.0, 0.05, 0.5)),
)


def walked(pair, seconds):
    """Take the ticks of some seconds; return the pair."""
    for _ in range(round(seconds * pair.crawl.params.rate_hz)):
        pair.tick()
    return pair


def test_whole_walks_go_the_same_way_to_the_tick_over_any_ground():
    """Of all ticks less than one in a thousand is taken again for a doubtful answer; everything there is happens."""
    met, ticks, turned = set(), 0, 0

    @settings(max_examples=30)
    @example(Trouble(steps=[(0.15, 0.03)]), ROBOTS[0], False, 1)
    @example(Trouble(calves=0.4), ROBOTS[0], False, 1)
    @example(Trouble(straight=0.6), ROBOTS[0], False, 1)
    @example(Trouble(steps=[(0.14, -0.12)]), ROBOTS[0], False, 1)
    @example(Trouble(steps=[(0.17, 0.09)]), ROBOTS[0], False, 1)
    @example(Trouble(steps=[(0.02, 0.05)]), ROBOTS[0], False, 1)
    @example(Trouble(sinks=1.0), ROBOTS[0], False, 1)
    @example(Trouble(skew=1.6, sticks=True), ROBOTS[0], False, 1)
    @given(TROUBLES, st.sampled_from(ROBOTS), st.booleans(), st.integers(0, 1 << 20))
    def walks(trouble, robot, planar, seed):
        nonlocal ticks, turned
        pair = walked(Pair(trouble, random.Random(seed), *robot, planar=planar and robot[0] == "caramelo"), 12.0)
        ticks, turned = ticks + 12 * robot[1], turned + pair.turned
        met.update(pair.met)

    walks()
    assert met == set(range(twin.LANDED, twin.RIM + 1))
    assert turned < ticks / 1000


def test_a_long_walk_on_level_ground_and_on_a_slope():
    """Sensing in order, one landing each, until the ground counts as even; the front feet then expect the slope."""
    for slope in (0.0, 0.15):
        pair = walked(Pair(Trouble(slope=slope), random.Random(1)), 50.0)
        assert pair.met == {twin.LANDED}
        assert pair.twin.landings == pair.twin.even_landings > 16
        while pair.twin.leg > 1 or pair.twin.stage != twin.SWING:
            pair.tick()
        x, _, z = pair.twin.feet[pair.twin.leg]
        rise = slope * (pair.twin.swing.target[0] - x)
        assert pair.crawl.swing.ground * pair.fine_m - z == pytest.approx(rise, abs=0.1e-3)


@pytest.mark.parametrize("rise_m", [0.03, 0.09, -0.03, -0.07])
@pytest.mark.parametrize("robot", [("caramelo", 50), ("parallel", 100)])
def test_where_it_strides_out_it_meets_an_edge(robot, rise_m):
    """Long strides, then usual ones again: the hind feet that have strode out get two footholds before the edge."""
    pair = Pair(Trouble(steps=[(0.45, rise_m)]), random.Random(2), *robot)
    long = pair.crawl.params.crawl.long_stride * pair.unit_m
    while not pair.twin.long_strides:
        pair.tick()
    steps, laid = [], False
    while not laid:
        waiting = [len(footholds) for footholds in pair.twin.footholds]
        pair.tick()
        laid = any(then == 1 and len(now) == 3 for then, now in zip(waiting, pair.twin.footholds, strict=True))
        if pair.twin.long_strides and pair.twin.stage == twin.LIFT and pair.twin.ticks == 0:
            steps.append(pair.twin.swing.target[0] - pair.twin.feet[pair.twin.leg][0])
    assert pair.met > {twin.LANDED}
    assert max(steps) == pytest.approx(long, rel=0.25)
    walked(pair, 12.0)


@pytest.mark.parametrize("robot", [robot for robot in ROBOTS if robot[0] != "long-leg"])
def test_any_point_of_a_crawl_goes_on_the_same_way(robot):
    """Points that a walk hardly ever comes to: any try, any ground, any load. (The long leg's have no room to plan.)"""

    @settings(max_examples=35)
    @given(st.integers(0, 1 << 20))
    def points(seed):
        pair = Pair(Trouble(), random.Random(seed), *robot, planar=seed % 8 == 7)
        for _ in range(60):
            pair.jump()
        assert pair.turned < 5

    points()


QUICK = {"long_stride": 30, "quick_swing_speed": 15000, "quick_lower_acceleration": 1000, "quick_lower_speed": 4000}


@pytest.mark.parametrize("setting", QUICK)
def test_a_quick_setting_that_is_a_little_off_in_the_core_is_seen(setting):
    """The comparison can fail where strides are long, too."""
    pair = Pair(Trouble(), random.Random(1))
    tuned = pair.crawl.params.crawl
    setattr(tuned, setting, getattr(tuned, setting) + QUICK[setting])
    with pytest.raises(AssertionError, match="core"):
        walked(pair, 30.0)


PLANTED = {
    "hang_ticks": 1,  # a tick later
    "share_ticks": 1,
    "contact_ticks": 1,
    "settle_ticks": 1,
    "stride": 20,  # 0.15 mm
    "edge_height": 100,
    "drop_depth": 30,
    "calf_lift": 60,
    "sink": 60,
    "stand_lift": 200,  # 1.5 mm: the foot goes 2 mm down in a tick
    "edge_advance": 60,
    "hind_lift": 60,
    "unknown_lower_speed": 1000,
    "loaded_lower_speed": 4000,
}


@pytest.mark.parametrize("setting", PLANTED)
def test_a_setting_that_is_a_little_off_in_the_core_is_seen(setting):
    """The comparison can fail: each is found in one of a few walks."""

    def walks():
        for seed in range(40):
            dice = random.Random(seed)
            steps = [(dice.uniform(0.05, 0.3), dice.choice((0.0185, 0.05, -0.03, -0.06)))]
            pair = Pair(Trouble(steps=steps, calves=0.3, straight=0.3, sinks=0.2, pauses=0.1), dice)
            tuned = pair.crawl.params.crawl
            setattr(tuned, setting, getattr(tuned, setting) + PLANTED[setting])
            walked(pair, 12.0)

    with pytest.raises(AssertionError, match="core"):
        walks()


def test_a_stage_that_goes_on_a_tick_early_is_seen(monkeypatch):
    """The comparison can fail: a front foot that lands at the first touch, a body that does not wait."""
    for name, wrong in (("feel_ground", lambda *_: 1), ("swing_foot", lambda *_: 1), ("corner_lift", lambda *_: 0)):
        with monkeypatch.context() as planted:
            planted.setattr(crawl_steps, name, wrong)
            with pytest.raises(AssertionError, match="core"):
                walked(Pair(Trouble(calves=1.0), random.Random(1)), 14.0)
