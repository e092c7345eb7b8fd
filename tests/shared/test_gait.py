"""The trajectories the planner produces, measured: duty factor, phase offsets, stance speed, lift, drift, mirror.

A walk is measured at one rate. That it is the same at every rate is told by the float planner (test_planner_twin.py).
"""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.gait import steps as s
from shared.gait import table as g
from shared.planner import status as n
from shared.record import pack, unpack
from tests.float_twin.gait import Gait
from tests.float_twin.si import leg_si
from tests.float_twin.swing import lift

from .bars import integers
from .robots import block
from .walker import NAMES, TABLE_GAITS, TABLES, Walker

RATE_HZ = 50
EVERY_GAIT = pytest.mark.parametrize("gait", TABLE_GAITS)


class Trace:
    """Two whole cycles of a walk that has settled: feet in the base frame and legs in the air at every tick."""

    def __init__(self, gait, **speed):
        self.walker = Walker("caramelo", RATE_HZ)
        self.command = self.walker.walk(gait, **speed)
        self.table = TABLE_GAITS[gait]
        self.cycle = self.walker.planner.gaits[NAMES.index(gait)].cycle
        self.walker.ticks(1 + 3 * self.cycle)
        while self.walker.planner.clock.segment or self.walker.planner.clock.tick:
            self.walker.tick()
        self.feet, self.air = [], []
        for _ in range(2 * self.cycle):
            self.walker.tick()
            self.feet.append(self.walker.feet_m())
            self.air.append(self.walker.swinging())

    def aloft(self, leg):
        """Return for each tick of the second cycle if the foot is off the ground between it and the next."""
        ground_m = leg_si(self.walker.params, leg).rest[2]
        up = [feet[leg][2] > ground_m for feet in self.feet[self.cycle :]]
        return [up[t] or up[(t + 1) % self.cycle] for t in range(self.cycle)]

    def advances(self):
        """Return the body's way along x in each tick of the second cycle, as the standing feet see it."""
        ways = []
        for t in range(self.cycle, 2 * self.cycle):
            standing = [leg for leg in range(4) if not (self.air[t] | self.air[t - 1]) >> leg & 1]
            steps = [self.feet[t - 1][leg][0] - self.feet[t][leg][0] for leg in standing]
            ways.append(sum(steps) / len(steps) if steps else None)
        return ways


def share_in_air(table, leg):
    """Return the share of the cycle a table keeps a leg in the air, from its milliseconds."""
    return sum(row[0] for row in table[1] if row[1] >> leg & 1) / sum(row[0] for row in table[1])


def lift_off(table, leg):
    """Return when in the cycle, as a share of it, a table lifts a leg."""
    rows = table[1]
    first = next(i for i, row in enumerate(rows) if row[1] >> leg & 1 and not rows[i - 1][1] >> leg & 1)
    return sum(row[0] for row in rows[:first]) / sum(row[0] for row in rows)


@EVERY_GAIT
def test_duty_factor_and_phase_offsets_are_the_tables(gait):
    trace = Trace(gait, vx_m_s=0.05)
    for leg in range(4):
        in_air = [bits >> leg & 1 for bits in trace.air[trace.cycle :]]
        wanted = share_in_air(trace.table, leg)
        assert 1 - sum(in_air) / trace.cycle == pytest.approx(1 - wanted, rel=0.01)
        start = next(t for t in range(trace.cycle) if in_air[t] and not in_air[t - 1])
        assert abs(start / trace.cycle - lift_off(trace.table, leg)) <= 0.01


@EVERY_GAIT
def test_the_foot_itself_keeps_the_duty_factor(gait):
    """Measured by height alone. The paper's swing has both its ends among the samples, so it is one tick shorter."""
    trace = Trace(gait, vx_m_s=0.05)
    shorter = 1 if gait == "paper-trot" else 0
    for leg in range(4):
        ticks = sum(bits >> leg & 1 for bits in trace.air[trace.cycle :])
        assert abs(sum(trace.aloft(leg)) - (ticks - shorter)) <= 0.01 * trace.cycle


@EVERY_GAIT
def test_stance_speed_is_the_commanded_one(gait):
    trace = Trace(gait, vx_m_s=0.05)
    advances = trace.advances()
    known = [way for way in advances if way is not None]
    wanted = trace.command[0] * trace.cycle
    share = Gait(trace.table, RATE_HZ)
    seen = sum(share.way(t) for t, way in enumerate(advances) if way is not None) / trace.cycle
    assert sum(known) == pytest.approx(wanted * seen, rel=0.01)
    assert trace.command[0] * RATE_HZ == pytest.approx(0.05, rel=0.001)


def test_an_even_gait_moves_the_body_alike_in_every_tick():
    trace = Trace("even-trot", vx_m_s=0.05)
    unit = trace.walker.unit_m
    for way in trace.advances():
        assert way is None or abs(way - trace.command[0]) <= max(1.01 * unit, 0.01 * trace.command[0])


@pytest.mark.parametrize("wz_rad_s", [0.3, -0.05])
def test_turning_speed_is_the_commanded_one(wz_rad_s):
    """The standing feet turn about the middle of the body, all four alike."""
    trace = Trace("even-trot", vx_m_s=0.0, wz_rad_s=wz_rad_s)
    turned = []
    for t in range(trace.cycle, 2 * trace.cycle):
        for leg in range(4):
            if not (trace.air[t] | trace.air[t - 1]) >> leg & 1:
                (x0, y0, _), (x1, y1, _) = trace.feet[t - 1][leg], trace.feet[t][leg]
                turned.append(math.atan2(x1 * y0 - y1 * x0, x0 * x1 + y0 * y1))
    assert sum(turned) / len(turned) == pytest.approx(trace.command[2], rel=0.01)


@EVERY_GAIT
def test_lift_is_the_configured_height(gait):
    for height_lu in (0, 2000, 4321):
        walker = Walker("caramelo", 50)
        walker.command.height = height_lu
        walker.walk(gait, vx_m_s=0.03)
        table = Gait(TABLE_GAITS[gait], 50)
        highest = [0] * 4
        rest = [foot[2] for foot in walker.feet_m()]
        for _ in range(3 * table.cycle):
            walker.tick()
            highest = [max(h, foot[2] - z) for h, foot, z in zip(highest, walker.feet_m(), rest, strict=True)]
        wanted = height_lu * walker.unit_m if height_lu else table.height_m
        ticks = next(table.lifts(0, place) for place in range(table.cycle) if table.lifts(0, place))
        sampled = max(lift(phase) for phase in table.phases(ticks))
        assert sampled >= 0.99
        assert highest == pytest.approx([wanted * sampled] * 4, abs=2 * walker.unit_m)


def test_a_height_that_changes_in_the_air_waits_for_the_next_swing():
    walker = Walker("caramelo", 500)
    walker.walk("even-trot", vx_m_s=0.05)
    last, worst = None, 0.0
    for tick in range(1200):
        walker.command.height = 6000 if tick % 7 < 3 else 300
        walker.tick()
        heights = [foot[2] for foot in walker.feet_m()]
        worst = max([worst] + [abs(a - b) for a, b in zip(heights, last or heights, strict=True)])
        last = heights
    assert worst <= math.pi / 120 * 6000 * walker.unit_m + walker.unit_m


@EVERY_GAIT
def test_a_straight_command_gives_no_sideways_drift(gait):
    """Not by a bit: along x nothing moves on y, along y nothing on x, and nothing creeps out of its place."""
    for speed, still in (({"vx_m_s": 0.06}, 1), ({"vx_m_s": 0.0, "vy_m_s": -0.04}, 0)):
        walker = Walker("caramelo", 50)
        walker.walk(gait, **speed)
        rest = [foot[still] for foot in walker.feet_m()]
        for _ in range(2000):
            walker.tick()
            assert [foot[still] for foot in walker.feet_m()] == rest


@EVERY_GAIT
def test_feet_keep_their_place_over_a_long_walk(gait):
    """After 100 s in a curve the footholds are those of the third cycle, to the unit."""
    walker = Walker("caramelo", 50)
    walker.walk(gait, vx_m_s=0.04, vy_m_s=0.01, wz_rad_s=0.2)
    cycle = walker.planner.gaits[NAMES.index(gait)].cycle
    while walker.state != n.WALKING or walker.planner.clock.segment or walker.planner.clock.tick:
        walker.tick()
    walker.ticks(3 * cycle)
    early = pack(walker.planner.feet)
    walker.ticks(5000 // cycle * cycle)
    assert max(abs(x - y) for x, y in zip(early, pack(walker.planner.feet), strict=True)) <= 2


MIRROR = (1, 0, 3, 2)


def mirrored_table(table):
    """Return a gait with left and right swapped."""
    rows = tuple(
        (ms, sum(1 << MIRROR[leg] for leg in range(4) if legs >> leg & 1), share) for ms, legs, share in table[1]
    )
    return table[0], rows


def mirror_error(gait, spoil=None):
    """Walk a curve with a moving body and its mirror image; return the largest difference of feet (lu) and joints."""
    pair = [Walker("caramelo", 50), Walker("caramelo", 50)]
    if spoil:
        spoil(pair[1])
    pair[1].planner.gaits = [g.compile_gait(mirrored_table(table), pair[1].params) for table in TABLES]
    for walker, sign in zip(pair, (1, -1), strict=True):
        walker.walk(gait, 0.04, sign * 0.02, sign * 0.2)
        unpack(walker.command.pose, (900, sign * 700, 400, sign * 500, 300, sign * 400))
    feet, joints = 0, 0
    for _ in range(400):
        for walker in pair:
            walker.tick()
        placed = [pack(walker.planner.feet) for walker in pair]
        for leg in range(4):
            for axis in range(3):
                here, there = leg * 3 + axis, MIRROR[leg] * 3 + axis
                sign = -1 if axis == 1 else 1
                feet = max(feet, abs(placed[0][here] - sign * placed[1][there]))
                sign = -1 if axis == 0 else 1
                joints = max(joints, abs(pair[0].planner.joints[here] - sign * pair[1].planner.joints[there]))
    return feet, joints


@EVERY_GAIT
def test_left_and_right_mirror(gait):
    feet, joints = mirror_error(gait)
    assert feet <= 5
    assert joints <= 6


def test_the_mirror_test_sees_a_planted_asymmetry():
    def spoil(walker):
        walker.params.legs[2].rest[1] += 20

    assert mirror_error("even-trot", spoil)[0] >= 15


@pytest.mark.parametrize("name", ["caramelo", "parallel", "long-leg"])
@pytest.mark.parametrize("rate_hz", [20, 50, 100, 333, 500])
def test_a_compiled_gait_is_the_float_gait(rate_hz, name):
    params = block(name, rate_hz)
    for table in TABLES:
        made, exact = g.compile_gait(table, params), Gait(table, rate_hz)
        assert made.cycle == exact.cycle
        for leg in range(4):
            assert made.stance_q10[leg] / 1024 == pytest.approx(exact.way_of_stance[leg], abs=0.25)
        clock = g.Clock()
        for place in range(exact.cycle):
            assert s.body_advance(made, clock) / 1024 == pytest.approx(exact.way(place), abs=8e-3 + 5e-5 * exact.cycle)
            assert g.gait_clock(made, clock) == (place == exact.cycle - 1)


@pytest.mark.parametrize(
    ("table", "part"),
    [
        (((35, 100, 100, 0), ()), "1 .. 8 segments"),
        (((35, 100, 100, 0), ((0, 0, 1),)), "duration"),
        (((35, 100, 100, 0), ((100, 16, 1),)), "legs 0 .. 15"),
        (((35, 100, 100, 0), ((100, 9, 0), (100, 6, 0))), "add up to 0"),
        (((35, 100, 100, 1), ((100, 9, 1), (100, 6, 1))), "even profile"),
        (((35, 100, 100, 0), ((900000, 0, 1),)), "16383 ticks"),
        (((35, 100, 100, 0), ((2000, 9, 0), (100, 0, 1))), "8 times"),
    ],
)
def test_a_table_that_is_no_gait_is_refused_with_a_sentence(table, part):
    with pytest.raises(ValueError, match=part):
        g.compile_gait(table, block("caramelo"))


@settings(max_examples=600)
@given(integers(-(1 << 19) + 1, (1 << 19) - 1), integers(0, (1 << 24) - 1))
def test_way_is_the_product(speed, ticks_q10):
    if abs(speed) * (ticks_q10 >> 10) < 1 << 29:
        assert abs(s.travel(speed, ticks_q10) - speed * ticks_q10 / 1024) <= 0.5


@settings(max_examples=600)
@given(integers(-(1 << 17), 1 << 17), integers(-65535, 65535), integers(0, (1 << 24) - 1))
def test_turned_way_is_the_product(turn, arm_lu, ticks_q10):
    exact = turn * ticks_q10 / 1024
    if abs(turn) * (ticks_q10 >> 10) < 1 << 29:
        angle = max(-1.0, min(1.0, exact / 2**18))
        error = abs(s.turned_travel(turn, arm_lu << 8, ticks_q10) - angle * arm_lu * 256)
        assert error <= 2 + 256 * abs(arm_lu) / 30000


@settings(max_examples=200)
@given(st.integers(-4000, 4000), st.integers(-4000, 4000), st.integers(0, 32768))
def test_between_is_on_the_line(start, end, share):
    got = s.between(start << 8, end << 8, share)
    assert abs(got - (start + (end - start) * share / 32768)) <= 1
