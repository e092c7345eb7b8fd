"""The trot in integers and in floats, tick by tick, on drives that lag as the robot's do."""

import math
import random
from collections import deque

import pytest

from host.robot import trot_tuning as tuning
from host.robot.file import load_robot
from host.robot.scale import BRAD_PER_RAD, core_params, scale_of
from shared.body.axes import Pose, Twist
from shared.record import pack, unpack
from shared.sense.legs import MeasuredFeet, Sensing, sense_legs
from shared.sense.odometry import Odometry
from shared.sense.sensed import Sensed
from shared.trot.clock import hurried_step
from shared.trot.feet import held_up_way_q15, limit_push
from shared.trot.state import CYCLE_Q20, Trot
from shared.trot.trot import trot_start, trot_tick

from .reference import FloatTrot, Senses, way

# Worst seen over 12 s: 29 brad (0.16 deg), at 200 Hz, where a brad of a step is led by seven ticks of lag, and 0.53 mm,
# in the long stances of a walk with care, where the rounding of each tick adds up.
MOST_BRAD, MOST_M = 40, 0.0006
MOST_UNEVEN_M = 0.00001  # in one tick


class Plant:
    """Drives that follow goals after the bus's delay, behind their lag."""

    def __init__(self, twin, rate_hz):
        first, late = list(twin.goals()), 1 + rate_hz // 50
        twin.load = [0.0] * 4  # as both trots begin
        self.sent, self.at = deque([first] * late, maxlen=late), first
        self.share = 1 / (1 + twin.f.lag_s * rate_hz)

    def joints_brad(self, goals=None):
        self.at = [a + self.share * (g - a) for a, g in zip(self.at, self.sent[0], strict=True)]
        return [round(a * BRAD_PER_RAD) for a in self.at]


class Pair:
    """Both trots of one robot, on the same senses and commands."""

    def __init__(self, name, rate_hz):
        robot, self.feet, self.sensing = load_robot(name), MeasuredFeet(), Sensing()
        self.params, self.scale, self.rate_hz = core_params(robot, rate_hz), scale_of(robot, rate_hz), rate_hz
        self.odometry = Odometry()
        self.twin, self.walk, self.goal = FloatTrot(robot, rate_hz), Trot(self.feet, self.odometry), [0] * 12
        trot_start(self.params, self.walk)
        self.plant, self.sensed = Plant(self.twin, rate_hz), Sensed()
        self.worst_brad = self.worst_m = 0.0

    def tick(self, speed, tilt, turned, known=True, pose=(0,) * 6, moving=True, balance=True):
        """speed: m/s, m/s, rad/s; tilt: brad; turned: 2^-18 rad; pose: lu, brad."""
        scale, sensed = self.scale, self.sensed
        told = [scale.lf_per_tick(speed[0]), scale.lf_per_tick(speed[1]), scale.yaw18_per_tick(speed[2])]
        sensed.joints[:], sensed.tilt[:] = self.plant.joints_brad(), tilt
        unpack(sensed.turned, turned)
        sensed.valid.joints, sensed.valid.tilt, sensed.valid.turned = int(known), 1, 1
        went = [told[0] * 15 >> 4, told[1] * 15 >> 4]  # always a bit too slow
        unpack(self.odometry.speed, went)
        self.twin.phase = self.walk.state.phase_q20 / 2**20  # what a tick of it is rounded to adds up
        uneven_m = scale.metres(self.walk.state.uneven_q4 / 16)
        assert self.twin.uneven == pytest.approx(uneven_m, abs=MOST_UNEVEN_M)
        self.twin.uneven = uneven_m  # else the two begin to walk with care at different ticks
        self.twin.careful = self.walk.state.careful > 0
        self.twin.no_care_s = max(0, -self.walk.state.careful) * self.twin.dt
        senses = Senses(
            [q / BRAD_PER_RAD for q in sensed.joints],
            tuple(t / BRAD_PER_RAD * known for t in tilt),
            tuple(t * self.rate_hz / 2**18 * known for t in turned),
            known,
            tuple(map(scale.metres_per_second, went)),
        )
        speed_si = scale.metres_per_second(told[0]), scale.metres_per_second(told[1]), told[2] * self.rate_hz / 2**18
        pose_si = [scale.metres(p) for p in pose[:3]] + [p / BRAD_PER_RAD for p in pose[3:]]
        goals = self.twin.tick(senses, speed_si, pose_si, moving, balance)
        self.walk.command.moving, self.walk.command.balance = int(moving), int(balance)
        sense_legs(self.params, sensed.joints, 0, 0, self.feet, self.sensing)
        trot_tick(self.params, self.walk, sensed, unpack(Twist(), told), unpack(Pose(), pose), self.goal)
        self.plant.sent.append(goals)
        self._compare(goals)

    def walk_with_a_held_foot(self, first=100, ticks=7):
        """Do 160 ticks, yield each one's number behind it; from ``first`` on a leg's thigh and calf do not move."""
        seen, free = [], self.plant.joints_brad

        def held():
            joints = free()
            if first <= len(seen) < first + ticks:
                joints[1:3] = seen[first - 1][1:3]
            seen.append(joints)
            return joints

        self.plant.joints_brad = held
        for n in range(160):
            self.tick((0.15 * min(1.0, n / 50), 0.0, 0.0), (0, 0), (0, 0, 0), moving=n > 25)
            yield n

    def _compare(self, goals):
        assert list(self.walk.stance) == self.twin.stance
        for mine, other in zip(self.goal, goals, strict=True):
            self.worst_brad = max(self.worst_brad, abs(mine - other * BRAD_PER_RAD))
        for mine, foot in zip(self.walk.feet.legs, self.twin.feet, strict=True):
            off_m = [abs(self.scale.metres(place / 256) - exact) for place, exact in zip(pack(mine), foot, strict=True)]
            self.worst_m = max(self.worst_m, *off_m)


def wander(pair, seconds, seed, gap=(5.0, 5.2)):
    """Commands that change, tilts and rates of noise, a while without senses, and a stop."""
    rng, rate = random.Random(seed), pair.rate_hz
    speed, wanted, tilt, pose = [0.0] * 3, [0.0] * 3, [0, 0], [0] * 6
    for n in range(round(seconds * rate)):
        if n % (2 * rate) == rate // 2:
            wanted = [rng.uniform(-most, most) for most in (0.2, 0.08, 0.5)]
        if n > (seconds - 2) * rate:
            wanted = [0.0] * 3
        for axis, most in enumerate((0.3, 0.3, 1.5)):
            speed[axis] += max(-most / rate, min(most / rate, wanted[axis] - speed[axis]))
        tilt = [max(-150, min(150, t + rng.randint(-9, 9))) for t in tilt]
        # a body that does not tilt as it is told has its feet turned on and on, and the twin knows no reach of legs
        most = (900, 900, 900, 200, 200, 900)
        pose = [round(top * math.sin(n / rate + axis) * min(1.0, n / rate)) for axis, top in enumerate(most)]
        known = not gap[0] < n / rate < gap[1]
        rates = [rng.randint(-200, 200) for _ in range(3)]
        pair.tick(speed, tilt, rates, known, pose, n > rate // 2, balance=n % (3 * rate) > rate // 2)


@pytest.mark.parametrize("rate_hz", [50, 100, 200])
@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_integers_and_floats_agree(name, rate_hz):
    pair = Pair(name, rate_hz)
    wander(pair, 12.0, seed=5)
    assert pair.worst_brad < MOST_BRAD
    assert pair.worst_m < MOST_M
    assert pair.walk.state.held_up_count == 0
    assert pair.walk.state.early_contacts == 0


def test_a_foot_that_meets_something_is_the_same_in_both():
    """A joint held where it is in a swing: the foot is late, then early, and the next swings are high."""
    pair = Pair("caramelo", 50)
    for _ in pair.walk_with_a_held_foot():
        pass
    assert pair.walk.state.held_up_count + pair.walk.state.early_contacts > 0
    assert pair.walk.state.high_left > 0
    assert pair.twin.high_left > 0
    assert max(pair.walk.apex) == pair.params.trot.highest_lift
    assert pair.worst_m < MOST_M


@pytest.mark.parametrize("first", [115, 116])
def test_a_foot_that_meets_higher_ground_as_it_comes_down_is_the_same_in_both(first):
    """A leg stays folded towards the end of a high swing."""
    pair = Pair("caramelo", 50)
    for _ in pair.walk_with_a_held_foot(first, ticks=3):
        pair.walk.state.high_left = pair.params.trot.high_distance
        pair.twin.high_left = tuning.HIGH_LENGTHS * pair.twin.f.length_m
    assert pair.walk.state.early_contacts == 1
    assert pair.worst_m < MOST_M


def test_a_foot_that_was_held_up_rises_before_it_goes_ahead():
    """Over all shares of a swing within 4 LSB of the float; the foot itself goes back first, ahead once it is high."""
    pair = Pair("caramelo", 50)
    for share in range(32768):
        part = min(1.0, max(0.0, (share / 32768 - tuning.AHEAD_FROM) / (tuning.AHEAD_TO - tuning.AHEAD_FROM)))
        assert held_up_way_q15(pair.params, share) == pytest.approx(32768 * way(part), abs=4)
    walk, way_m = pair.walk, []
    for _ in pair.walk_with_a_held_foot():
        for leg, foot in enumerate(walk.feet.legs):
            if walk.rises_first[leg] and not walk.stance[leg]:
                x, z = pair.scale.metres(foot.x / 256), pair.scale.metres(foot.z / 256)
                way_m.append((x - pair.scale.metres(walk.lift_offs.legs[leg].x), z + pair.twin.h))
    leg_m = pair.twin.leg_m
    assert min(x for x, _ in way_m) < -0.9 * tuning.DRAW_BACK * leg_m
    assert next(z for x, z in way_m if x > 0.02 * leg_m) > 0.3 * leg_m


@pytest.mark.parametrize(("ahead", "rates", "pushed"), [
    (1, (0, 8000, 0), True),  # tips forward, at 0.27 m/s over its feet
    (1, (8000, 0, 0), True),
    (1, (-8000, 0, 0), True),
    (-1, (0, -8000, 0), True),
    (1, (0, -5000, 0), False),  # slower than told
    (1, (0, 0, 8000), False),
    (1, (0, 2000, 0), False),
])
def test_one_that_is_pushed_steps_sooner_in_both(ahead, rates, pushed):
    """The feet stand, and the body turns over them, from any tick of half a cycle on; a swing just begun ends at once.

    Afterwards it walks at its usual pace.
    """
    most = 0
    for first in range(70, 82):
        pair, paces = Pair("caramelo", 50), []
        state, setup = pair.walk.state, pair.params.trot
        for n in range(130):
            before = state.phase_q20
            turned = rates if first <= n < first + 20 else (0, 0, 0)
            pair.tick((0.1 * ahead, 0.0, 0.0), (0, 0), turned, moving=n > 25)
            paces.append(state.phase_q20 - before & CYCLE_Q20 - 1)
            assert pair.twin.pushed == (state.pushed > 0)
        assert (setup.hurried_step_q20 in paces[first + 2 :]) == pushed
        assert set(paces[26:first] + paces[120:]) == {setup.phase_step_q20}
        assert pair.worst_m < MOST_M
        most = max(most, *paces)
    swing_q20 = CYCLE_Q20 - setup.stance_q20
    assert (most > 0.7 * swing_q20) == pushed
    assert most < swing_q20 + setup.hurried_step_q20


@pytest.mark.parametrize(("name", "hurries"), [
    ("caramelo", False), ("spotmicro", False),  # servos: such swings alone ask more of them than they have
    ("parallel", True), ("pupper", True), ("solo12", True), ("unitree-a1", True), ("mini-cheetah", True),
])
def test_high_swings_go_on_faster_where_the_drives_can_follow(name, hurries):
    """Pushed while swings are high: none of them is cut short."""
    for first in range(70, 82, 3):
        pair, paces = Pair(name, 50), []
        state, setup = pair.walk.state, pair.params.trot
        for n in range(first + 20):
            if n == first - 5:
                state.high_left, pair.twin.high_left = setup.high_distance, tuning.HIGH_LENGTHS * pair.twin.f.length_m
            before, turned = state.phase_q20, (0, 12000, 0) if n >= first else (0, 0, 0)
            pair.tick((0.1, 0.0, 0.0), (0, 0), turned, moving=n > 25)
            paces.append(state.phase_q20 - before & CYCLE_Q20 - 1)
            assert pair.twin.pushed == (state.pushed > 0)
        assert set(paces[26:first]) == {setup.phase_step_q20}
        assert set(paces[first:]) == {setup.phase_step_q20, *([setup.hurried_step_q20] if hurries else [])}


def test_the_top_of_a_swing_is_skipped_to_where_the_foot_is_as_high():
    """Over all shares of a swing and the lengths that it may have."""
    pair = Pair("caramelo", 50)
    params, walk = pair.params, pair.walk
    walk.state.pushed = 1
    for stance_q20 in (CYCLE_Q20 >> 1, params.trot.stance_q20, CYCLE_Q20 * 3 >> 2):
        params.trot.stance_q20 = stance_q20
        for share in range(32768):
            exact = max(0.0, 1 - 2 * share / 32767) * (CYCLE_Q20 - stance_q20)
            walk.state.swing_q15 = share
            assert hurried_step(params, walk) - params.trot.hurried_step_q20 == pytest.approx(exact, abs=48)


def test_a_leg_that_can_not_lift_is_not_pushed_on_in_both():
    """It stands folded by 0.2 of the leg, and is sent 0.12 below that, not the whole way."""
    pair = Pair("caramelo", 50)
    lifted, free = 0.2 * pair.twin.leg_m, pair.plant.joints_brad
    x, y, z = pair.twin.feet[0]
    folded = [round(q * BRAD_PER_RAD) for q in pair.twin.inverse(0, (x, y, z + lifted))]
    pair.plant.joints_brad = lambda: folded + free()[3:] if len(pair.twin.past) > 5 else free()
    for _ in range(40):
        pair.tick((0.0, 0.0, 0.0), (0, 0), (0, 0, 0), moving=False)
    assert pair.worst_m < MOST_M
    below_m = pair.scale.metres(pair.walk.residual_z[0])
    assert 0.11 * pair.twin.leg_m < below_m < 0.15 * pair.twin.leg_m


@pytest.mark.parametrize("rate_hz", [20, 50, 500])
@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_what_a_standing_foot_is_spared_is_as_the_floats_say(name, rate_hz):
    """Over all that a foot can be off; at most 1 lf less, and what the rate's integer is rounded to."""
    pair = Pair(name, rate_hz)
    walk, params, twin = pair.walk, pair.params, pair.twin
    most, share = params.leg_length * 123 // 1024, 8 / twin.f.cycle_s / rate_hz
    for off in (*range(-40000, 40000, 37), most, most + 1, 32767 + most):
        walk.residual_z[0], walk.state.known = off, 100
        exact = min(32767, max(0, off - most)) * share * 256
        assert limit_push(params, walk, 0) == pytest.approx(exact, abs=1 + exact * 0.5 / params.trot.height_kp_q16)
        walk.state.known = params.delay_ticks
        assert limit_push(params, walk, 0) == 0
