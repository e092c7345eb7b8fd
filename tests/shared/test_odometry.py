"""shared/sense/odometry.py: exact for feet that stay, like the float twin for others, and whole to its ends."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.num.fixed import cos_q15, sin_q15
from shared.record import pack, unpack
from shared.sense import odometry as o
from shared.sense.legs import Sensing
from shared.sense.sensed import Sensed
from tests.float_twin.odometry import Odometry as Twin
from tests.float_twin.si import rad

from .robots import NAMES, block

FAR, SUM = 0x3FFF0000, 0x3F000000  # where the place stays, and what adds up beside it
FEET_M = ((0.15, -0.07), (0.15, 0.07), (-0.15, -0.07), (-0.15, 0.07))
ROLLED_M = ((-0.009, 0.002),) * 4  # about what Caramelo's feet have at rest, by calf and hip
EVEN = (0.25,) * 4


class Pair:
    """The core's and the twin's, of the same contacts."""

    def __init__(self, name="caramelo", rate_hz=50):
        self.params = block(name, rate_hz)
        self.unit_m = 1 / (1 << self.params.length_shift)
        self.core, self.sensing, self.sensed = o.Odometry(), Sensing(), Sensed()
        self.twin = Twin(rate_hz, self.params.leg_length * self.unit_m, self.params.delay_ticks)

    def step(self, feet_m, forces=EVEN, swinging=0, turned=None, tilt=(0.0, 0.0), walks=True, rolled=ROLLED_M):
        """One tick of both, the twin's with what the core is told once it is in whole numbers."""
        sensing, sensed = self.sensing, self.sensed
        roll, pitch = (round(angle / rad(1)) for angle in tilt)
        feet = [[round(value / self.unit_m) for value in foot] for foot in feet_m]
        off = [[round(value / self.unit_m) for value in foot] for foot in rolled]
        for leg, (at, by) in enumerate(zip(feet, off, strict=True)):
            unpack(sensing.level[leg], (*at, 0))
            unpack(sensing.rolled[leg], (at[0] - by[0], at[1] - by[1]))
        sensing.force_q12[:] = [round(force * 4096) for force in forces]
        sensing.roll_cosine_q13, sensing.pitch_cosine_q13 = cos_q15(roll) >> 2, cos_q15(pitch) >> 2
        sensing.pitch_sine_q13 = sin_q15(pitch) >> 2
        sensed.valid.turned = sensed.valid.tilt = int(turned is not None)
        unpack(sensed.turned, [round(angle * 2**18) for angle in turned or (0, 0, 0)])
        o.odometry_step(self.params, sensing, sensed, swinging, int(walks), self.core)
        at_m, off_m = ([(x * self.unit_m, y * self.unit_m) for x, y in each] for each in (feet, off))
        gyro = None if turned is None else [value / 2**18 for value in pack(sensed.turned)]
        weights = [(force >> 6) / 64 for force in sensing.force_q12]
        self.twin.step(at_m, off_m, weights, swinging, gyro, (rad(roll), rad(pitch)), walks)

    @property
    def place_m(self):
        return [value * self.unit_m for value in pack(self.core.place)]

    @property
    def yaw_rad(self):
        return math.tau * (self.core.turns + self.core.heading / 2**24)


def seen(body, foot):
    """Return where a foot of the ground is in the level axes of a body at (x, y, yaw)."""
    dx, dy, c, s = foot[0] - body[0], foot[1] - body[1], math.cos(body[2]), math.sin(body[2])
    return c * dx + s * dy, c * dy - s * dx


def rolled_m(tick):
    """Return how far each foot has rolled, x and y: all of them back and forth, as the calves of a walking robot."""
    return [(x - 0.004 * math.sin(tick / 5), y) for x, y in ROLLED_M]


def walk(pair, ticks, speed, gyro, slip_m=0.0, tilted=False, seed=1, walks=True):
    """Walk by diagonals that swing in turn; feet stay on the ground where they were set down, but roll and slip a bit.

    ``speed``: forward, left and turning, of a tick. Returns the true place.
    """
    dice, body, feet = random.Random(seed), [0.0, 0.0, 0.0], [list(foot) for foot in FEET_M]
    for tick in range(ticks):
        swinging = (6, 9)[tick // 12 % 2] if tick % 12 < 10 and tick and walks else 0
        middle = body[2] + speed[2] / 2
        if tick:
            body[0] += speed[0] * math.cos(middle) - speed[1] * math.sin(middle)
            body[1] += speed[0] * math.sin(middle) + speed[1] * math.cos(middle)
            body[2] += speed[2]
        rolled, rolls_m = rolled_m(tick), rolled_m(tick)[0][0] - rolled_m(tick - 1)[0][0]
        c, s = math.cos(body[2]), math.sin(body[2])
        for leg in range(4):
            if swinging >> leg & 1:
                x, y = FEET_M[leg][0] + 6 * speed[0], FEET_M[leg][1]
                feet[leg] = [body[0] + c * x - s * y, body[1] + s * x + c * y]
            else:
                on = rolls_m * math.cos(middle), rolls_m * math.sin(middle)
                feet[leg] = [value + part + dice.uniform(-slip_m, slip_m)
                             for value, part in zip(feet[leg], on, strict=True)]
        tilt = (0.2 * math.sin(tick / 9), 0.15 * math.cos(tick / 7)) if tilted else (0.0, 0.0)
        turned = about_body(speed[2], tilt) if gyro else None
        forces = [0.0 if swinging >> leg & 1 else 0.3 + dice.random() / 2 for leg in range(4)]
        pair.step([seen(body, foot) for foot in feet], forces, swinging, turned, tilt, walks, rolled)
    return body


def about_body(turn, tilt):
    """Return how a heading's turn reads about the axes of a tilted body, Ry(-pitch) Rx(-roll) z."""
    roll, pitch = tilt
    return -turn * math.cos(roll) * math.sin(pitch), turn * math.sin(roll), turn * math.cos(roll) * math.cos(pitch)


WAYS = ((0.006, 0.0, 0.0), (0.001, 0.0004, 0.0), (0.003, 0.0, 0.005), (0.0, 0.0, -0.008), (-0.002, 0.001, -0.002))


@pytest.mark.parametrize("speed", WAYS)
def test_over_feet_that_stay_10_m_are_right_within_2_mm(speed):
    """Measured: 0.37 mm and 0.014 deg at most, of the rounding of feet and turns."""
    pair = Pair()
    x, y, yaw = walk(pair, 1 + round(10 / 0.006), speed, gyro=True, tilted=True)
    assert math.dist(pair.place_m, (x, y)) < 0.002
    assert abs(pair.yaw_rad - yaw) < math.radians(0.05)


@pytest.mark.parametrize("speed", WAYS)
def test_feet_alone_tell_the_turn(speed):
    """Without a gyroscope; and of a robot that stands, whose gyroscope drifts."""
    for turned, walks in ((False, True), (True, False)):
        pair = Pair()
        still = tuple(value / 40 for value in speed) if not walks else speed  # a body that sways over feet that stand
        x, y, yaw = walk(pair, 400, still, gyro=turned, walks=walks)
        assert math.dist(pair.place_m, (x, y)) < 0.002 + 0.01 * abs(yaw)
        assert abs(pair.yaw_rad - yaw) < 0.01 * abs(yaw) + 1e-3
    core = pair.core
    assert (core.walked, core.slip, core.heading_sigma_q26) == (0, 0, 0), "nothing is doubted while it stands"


@pytest.mark.parametrize(("name", "rate_hz"), [(name, rate_hz) for name in NAMES for rate_hz in (20, 50, 500)])
def test_feet_that_slip_move_it_like_the_float_twin(name, rate_hz):
    """Measured: 0.45 mm and 3 mrad in 500 ticks, a turn by the feet within 1/1000; the spreads within an eighth."""
    for seed, speed in enumerate(WAYS):
        pair = Pair(name, rate_hz)
        walk(pair, 500, speed, gyro=seed % 2 == 0, slip_m=0.002, tilted=True, seed=seed)
        twin, core = pair.twin, pair.core
        assert math.dist(pair.place_m, (twin.x, twin.y)) < 0.002
        assert abs(pair.yaw_rad - twin.yaw) < 0.002 + abs(twin.yaw) / 500
        fine = pair.unit_m / 256 * rate_hz
        speed = [value * fine for value in pack(core.speed)]
        assert speed == pytest.approx([twin.vx, twin.vy], abs=0.002 * rate_hz / 50)
        assert core.turning / 2**24 * rate_hz == pytest.approx(twin.wz, abs=0.004 * rate_hz / 50)
        spreads_agree(pair)


def spreads_agree(pair):
    """Way, slip, heading_sigma and the vectors of the covariance are those of the twin."""
    twin, core, unit_m = pair.twin, pair.core, pair.unit_m
    o.odometry_spread(pair.params, core)
    scale_spread, place_spread = twin.spread()
    assert core.walked * unit_m == pytest.approx(twin.walked, rel=0.13, abs=0.002)
    assert core.slip * unit_m == pytest.approx(twin.slip, rel=0.05, abs=0.002)
    assert core.heading_sigma_q26 / 2**26 == pytest.approx(twin.heading_sigma, rel=0.05, abs=1e-4)
    by_heading_m = [value * unit_m / 256 for value in pack(core.heading_spread)]
    assert by_heading_m == pytest.approx(twin.heading_spread, rel=0.1, abs=0.002)
    assert [value * unit_m for value in pack(core.scale_spread)] == pytest.approx(scale_spread, rel=0.15, abs=0.001)
    assert core.place_spread * unit_m == pytest.approx(place_spread, rel=0.13, abs=0.001)


def test_a_foot_counts_by_the_square_of_what_it_carries_and_not_while_it_swings():
    pair, forces = Pair(), (0.2, 0.2, 0.4, 0.4)
    pair.step(FEET_M, forces)
    moved = [(x - 0.004, y) for x, y in FEET_M[:2]] + list(FEET_M[2:])
    pair.step(moved, forces, turned=(0, 0, 0))
    assert pair.place_m[0] == pytest.approx(0.004 * 0.04 / (0.04 + 0.16), rel=0.1)
    pair = Pair()
    for _ in range(pair.params.delay_ticks + 2):
        pair.step(FEET_M, turned=(0, 0, 0))
    for tick in range(20):  # legs 0, 1 are to swing: their feet tell nothing once the goals have had their effect
        pair.step([(x - 0.001 * (tick + 1) * (leg < 2), y) for leg, (x, y) in enumerate(FEET_M)], EVEN, 3, (0, 0, 0))
    assert pair.place_m[0] == pytest.approx(0.0005 * (pair.params.delay_ticks + 1), abs=1e-5)


def test_a_foot_that_lands_within_a_tick_does_not_count_for_it():
    """It has come some of its way through the air; a tick later it counts like the others."""
    pair = Pair()
    pair.step(FEET_M, (0.5, 0.0, 0.0, 0.5), turned=(0, 0, 0))
    for tick, foot_m in enumerate((0.02, 0.024), 1):
        lands = [(x - (foot_m if leg in (1, 2) else 0.004 * tick), y) for leg, (x, y) in enumerate(FEET_M)]
        pair.step(lands, EVEN, turned=(0, 0, 0))
        assert pair.place_m[0] == pytest.approx(0.004 * tick, rel=0.01)


@pytest.mark.parametrize(("name", "rate_hz"), [(name, rate_hz) for name in NAMES for rate_hz in (20, 50, 500)])
def test_what_all_feet_carry_is_of_those_that_may_and_of_one_that_lands_what_it_presses(name, rate_hz):
    """May: by the plan of now or of delay_ticks + 1 ticks ago. Lands: by that of now alone."""
    pair, dice, plans = Pair(name, rate_hz), random.Random(rate_hz), []
    late = pair.params.delay_ticks + 1
    while len(plans) < 2000:
        plans += [dice.randrange(16)] * dice.randint(late + 1, 3 * late)
    for tick, plan in enumerate(plans):
        forces = [dice.uniform(-16, 16) for _ in range(4)]
        pair.step(FEET_M, forces, plan)
        if tick > late:
            stood, stands = ([each >> leg & 1 == 0 for leg in range(4)] for each in (plans[tick - late], plan))
            exact = sum(force if was else max(force, 0.0) if now else 0.0
                        for force, was, now in zip(forces, stood, stands, strict=True))
            assert pair.core.carried_q12 / 4096 == pytest.approx(exact, abs=4 * 0.5 / 4096)


def test_where_no_foot_carries_it_goes_on_as_it_went_and_lost_it_stands():
    pair = Pair()
    walk(pair, 100, (0.004, 0.0, 0.0), gyro=True)
    before = pair.place_m[0]
    pair.step(FEET_M, (0.0,) * 4, swinging=15, turned=(0, 0, 0))
    assert pair.place_m[0] - before == pytest.approx(0.004, rel=0.02)
    o.odometry_lost(pair.core)
    lost = pack(pair.core.place)
    pair.step([(x - 0.05, y) for x, y in FEET_M], turned=(0, 0, 0.1))
    assert pack(pair.core.place) == lost, "nothing is told by legs that were not seen a tick ago"
    o.odometry_restart(pair.core)
    assert (pack(pair.core.place), pair.core.heading, pair.core.walked) == ([0, 0], 0, 0)


@pytest.mark.parametrize("force", [0.0, 0.06])
def test_where_the_joints_tell_of_no_weight_those_feet_count_that_are_to_stand(force):
    """However little the feet in the air seem to carry: 0.06 of the weight each."""
    pair = Pair()
    for tick in range(101):
        feet = [(x - 0.004 * tick if leg in (0, 3) else x + 0.01 * tick, y) for leg, (x, y) in enumerate(FEET_M)]
        pair.step(feet, (0.0, force, force, 0.0), swinging=6, turned=(0, 0, 0))
    assert pair.place_m[0] == pytest.approx(0.4, rel=0.03)


def test_in_the_plane_whose_gyroscope_tells_no_turn_the_feet_do():
    pair = Pair()
    pair.params.lateral_q12 = 0
    yaw = walk(pair, 200, (0.002, 0.0, 0.003), gyro=True)[2]
    assert pair.core.gyro == 0
    assert pair.yaw_rad == pytest.approx(yaw, rel=0.01)


def test_the_heading_goes_on_for_many_turns():
    pair = Pair()
    yaw = walk(pair, 3000, (0.0, 0.0, 0.03), gyro=True)[2]
    assert pair.core.turns == round(yaw / math.tau) == 14
    assert pair.yaw_rad == pytest.approx(yaw, abs=0.01)


@given(st.integers(0, 3), st.booleans(), st.integers(-32767, 32767), st.integers(-32767, 32767), st.integers(0, 2**25))
@settings(max_examples=300)
def test_at_its_ends_it_stays(corner, walks, ahead, aside, near):
    """8 km from where it began it is told to be there; the way and the uncertainties, too, stay at their largest."""
    core, params = o.Odometry(), block("caramelo")
    signs = (1 if corner & 1 else -1), (1 if corner & 2 else -1)
    unpack(core.place, [sign * (FAR - near % 12000) for sign in signs])
    unpack(core.heading_spread, [sign * (SUM - near % 4096) for sign in signs])
    core.walked = core.slip = FAR - near % 4096
    core.heading_sigma_q26 = SUM - near % 4096
    core.heading = (near << 1) - (1 << 25) >> 2
    o.place_body(ahead, aside, 32768, int(walks), core)
    o.add_distance(params, ahead, aside, 131068, core)
    o.odometry_spread(params, core)
    assert max(abs(value) for value in pack(core)) < 1 << 30
    assert max(abs(value) for value in pack(core.place)) <= FAR
    assert core.walked <= FAR
    assert core.heading_sigma_q26 <= SUM
    assert FAR / (1 << params.length_shift) == pytest.approx(8191.5)
