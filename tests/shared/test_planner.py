"""shared/planner*.py: states and what leads from one to the other, stillness, speed limits, any input survived."""

import math
import random
from itertools import pairwise

import pytest

from host.lab.parity.probe.row import Row
from shared.body.reach import INSIDE_HIP, TOO_FAR, TOO_NEAR
from shared.gait import steps as s
from shared.planner import command as c
from shared.planner import status as n
from shared.record import pack, unpack
from tests.float_twin.gait import Gait

from .bars import any_word
from .walker import NAMES, TABLES, Walker

# Walked by footholds in planner.steps; the trot is held to its own: tests/shared/trot/test_mover.py.
NO_CRAWL = [place for place, name in enumerate(NAMES) if name not in ("crawl", "trot")]
STEP_BITS = 4  # rounding of a slow move, see shared/planner/posture.py


def limits_of(params):
    """Return the lowest and the highest angle of the twelve joints."""
    low = [angle for leg in params.legs for angle in leg.lowest]
    high = [angle for leg in params.legs for angle in leg.highest]
    return low, high


def in_state(state, rate_hz=50):
    """Return a walker that has got into a state, in the middle of it."""
    walker = Walker("caramelo", rate_hz)
    if state == n.LIMP:
        walker.tick()
    elif state == n.RISING:
        walker.mode(c.MODE_STAND)
        walker.ticks(10)
    elif state == n.FOLDING:
        walker.mode(c.MODE_FOLD)
        walker.ticks(40)
    elif state == n.WALKING:
        walker.walk("even-trot", 0.05, 0.01, 0.1)
        walker.ticks(79)
        assert walker.swinging()
    else:
        walker.stand()
        if state != n.STANDING:
            walker.mode(c.MODE_SIT)
            walker.until(n.SITTING)
            walker.ticks(5)
        if state == n.SEATED:
            walker.until(n.SEATED)
    assert walker.state == state
    return walker


@pytest.mark.parametrize("state", range(7), ids=n.STATE_NAMES)
def test_limp_from_every_state_at_once(state):
    walker = in_state(state)
    walker.mode(c.MODE_LIMP)
    fallen = [100 * joint - 600 for joint in range(12)]
    walker.sensed.joints[:] = fallen
    assert walker.planner.tick(walker.command, walker.sensed) & ~n.ODD_READING == n.NOT_DRIVEN
    assert walker.state == n.LIMP
    assert walker.swinging() == 0
    for _ in range(30):
        assert walker.planner.tick(walker.command, walker.sensed) == n.NOT_DRIVEN
    assert list(walker.planner.joints) == fallen


@pytest.mark.parametrize("state", range(7), ids=n.STATE_NAMES)
@pytest.mark.parametrize("mode", [c.MODE_STAND, c.MODE_WALK, c.MODE_SIT])
def test_every_mode_is_reached_from_every_state(state, mode):
    walker = in_state(state)
    walker.mode(mode)
    walker.speed(0.03)
    if state == n.LIMP and mode == c.MODE_SIT:
        walker.ticks(100)
        assert walker.state == n.LIMP  # a limp robot lies already
        return
    walker.until({c.MODE_STAND: n.STANDING, c.MODE_WALK: n.WALKING, c.MODE_SIT: n.SEATED}[mode])


@pytest.mark.parametrize("mode", [c.MODE_FOLD, c.MODE_STAND, c.MODE_SIT])
def test_a_robot_on_its_belly_folds_its_legs_before_it_puts_them_under_it(mode):
    """At its sides first, in the pose of the robot's data, slowly; whatever else is told meanwhile; then it sits."""
    walker = in_state(n.FOLDING)
    walker.mode(mode)
    lies = [angle for leg in walker.params.legs for angle in leg.folded]
    low, high = limits_of(walker.params)
    assert all(a <= b <= c for a, b, c in zip(low, lies, high, strict=True))
    folded = False
    while walker.state == n.FOLDING:
        before = list(walker.planner.joints)
        walker.tick()
        off = max(abs(a - b) for a, b in zip(walker.planner.joints, lies, strict=True))
        folded = folded or off <= walker.params.joint_speed_slow
        steps = [abs(a - b) for a, b in zip(walker.planner.joints, before, strict=True)]
        assert max(steps) <= walker.params.joint_speed_slow + 2
    assert folded
    assert walker.state == n.SEATED
    seat = walker.params.sit_z
    for leg, foot in zip(walker.params.legs, walker.feet_m(), strict=True):
        assert foot[2] == pytest.approx((leg.hip[2] + seat) * walker.unit_m, abs=0.001)


def test_nobody_sits_down_in_mid_stride():
    walker = in_state(n.WALKING)
    walker.mode(c.MODE_SIT)
    while walker.state == n.WALKING:
        walker.tick()
    assert walker.state in (n.STANDING, n.SITTING)
    assert s.steps_at_rest(walker.params, walker.planner.steps)
    walker.until(n.SEATED)


def slowly(walker, state):
    """Tick until a state is reached, no joint faster than a slow move's; return the joints."""
    last, slow = list(walker.planner.joints), walker.params.joint_speed_slow + STEP_BITS
    while walker.state != state:
        walker.tick()
        joints = list(walker.planner.joints)
        assert max(abs(a - b) for a, b in zip(last, joints, strict=True)) <= slow
        last = joints
    return last


def test_standing_up_starts_from_the_measured_pose_and_is_slow():
    walker = Walker("caramelo")
    low, high = limits_of(walker.params)
    dice = random.Random(3)
    lying = [dice.randint(a, b) for a, b in zip(low, high, strict=True)]
    walker.sensed.joints[:] = lying
    for _ in range(2):
        walker.planner.tick(walker.command, walker.sensed)
    assert list(walker.planner.joints) == lying
    walker.mode(c.MODE_STAND)
    standing = slowly(walker, n.STANDING)
    walker.tick()
    assert list(walker.planner.joints) == standing


def test_sitting_down_is_slow_and_ends_at_the_seat():
    walker = in_state(n.STANDING)
    walker.mode(c.MODE_SIT)
    seated = slowly(walker, n.SEATED)
    assert [foot[2] for foot in walker.feet_m()] == pytest.approx([walker.params.sit_z * walker.unit_m] * 4)
    walker.ticks(50)
    assert list(walker.planner.joints) == seated


def test_a_limp_robot_with_unknown_joints_stays_limp():
    walker = in_state(n.LIMP)
    walker.mode(c.MODE_STAND)
    walker.sensed.valid.joints = 0
    assert walker.tick() & n.NO_JOINTS
    assert walker.state == n.LIMP
    walker.sensed.valid.joints = 1
    assert walker.tick() == 0
    assert walker.state == n.RISING


@pytest.mark.parametrize("known", [0, 1])
def test_one_that_is_driven_sits_down_from_its_goals_whatever_is_measured(known):
    walker = in_state(n.STANDING)
    goals = list(walker.planner.joints)
    walker.mode(c.MODE_SIT)
    walker.sensed.valid.joints = known
    walker.sensed.joints[:] = [0] * 12
    walker.tick()
    assert walker.state == n.SITTING
    assert list(walker.planner.move.start) == goals


@pytest.mark.parametrize("after_walk", [False, True])
def test_zero_command_stands_still_to_the_bit(after_walk):
    walker = in_state(n.WALKING if after_walk else n.STANDING)
    walker.mode(c.MODE_WALK)
    walker.speed()
    walker.until(n.STANDING, 60)
    walker.tick()
    joints, feet = list(walker.planner.joints), pack(walker.planner.reached)
    for _ in range(10000):
        walker.tick()
        assert walker.state == n.STANDING
        assert list(walker.planner.joints) == joints
    assert pack(walker.planner.reached) == feet


def test_walks_that_stop_and_start_do_not_creep():
    """Thirty stops: each time the feet are back under their hips."""
    walker, dice = in_state(n.STANDING), random.Random(1)
    rest = pack(walker.planner.reached)
    for _ in range(30):
        walker.command.gait = dice.choice(NO_CRAWL)
        walker.speed(dice.uniform(-0.1, 0.1), dice.uniform(-0.05, 0.05), dice.uniform(-0.4, 0.4))
        walker.mode(c.MODE_WALK)
        walker.ticks(dice.randrange(20, 200))
        walker.mode(c.MODE_STAND)
        walker.until(n.STANDING, 60)
        walker.tick()  # the last foot comes down in the first tick of standing
        away = [abs(a - b) for a, b in zip(rest, pack(walker.planner.reached), strict=True)]
        assert max(away[0::3] + away[1::3]) <= 1
        assert max(away[2::3]) <= 1


def test_a_gait_changes_only_when_all_feet_stand_and_the_robot_is_slow_enough():
    walker, dice = in_state(n.STANDING), random.Random(2)
    walker.mode(c.MODE_WALK)
    changes = set()
    for tick in range(12000):
        if tick % 37 == 0:
            walker.command.gait = dice.choice(NO_CRAWL)
            walker.speed(dice.uniform(-0.3, 0.3), dice.uniform(-0.2, 0.2), dice.uniform(-1, 1))
        before = walker.planner.status.gait
        walker.tick()
        after = walker.planner.status.gait
        if before != after:
            changes.add((before, after))
            assert not any(step.ticks for step in walker.planner.steps.legs)
            tops = walker.planner.gaits[after].speed_max
            assert all(abs(v) <= top for v, top in zip(pack(walker.planner.speed), pack(tops), strict=True))
    assert len(changes) == len(NO_CRAWL) * (len(NO_CRAWL) - 1)


def foot_step_limit_m(walker):
    """Return how far a planned foot may move in one tick.

    Swing: the steepest phase step of any gait times twice the longest way (a cycloid's peak speed is twice its
    mean; the way is a stride along x and along y and by turning, in all no more than two), and pi times the height
    across it. Stance: the body's peak.
    """
    params, worst = walker.params, 0.0
    stride = 2 * params.stride_max * walker.unit_m
    height = -params.sit_z * walker.unit_m
    for table in TABLES:
        gait = Gait(table, walker.rate_hz)
        ticks = max(gait.lifts(0, place) for place in range(gait.cycle))
        phases = [*gait.phases(ticks), 1.0]
        steepest = max(b - a for a, b in pairwise(phases))
        peak = max(gait.way(place) for place in range(gait.cycle))
        worst = max(
            worst, steepest * math.hypot(2 * stride, math.pi * height) + peak * stride / max(gait.way_of_stance)
        )
    return worst


def restless_feet(walker, ticks, seed):
    """Drive anything at all; return the largest way of a planned foot in a tick while standing or walking, m."""
    command, dice, last, worst = walker.command, random.Random(seed), None, 0.0
    for tick in range(ticks):
        if tick % 23 == 0:
            for wish in (command.speed, command.pose):
                unpack(wish, [any_word(dice) for _ in pack(wish)])
            command.balance, command.height = any_word(dice), any_word(dice)
            command.mode = dice.choice((c.MODE_WALK, c.MODE_WALK, c.MODE_WALK, c.MODE_STAND))
            command.gait = dice.choice((-1, *NO_CRAWL, len(NAMES)))
        walker.tick()
        assert walker.state in (n.STANDING, n.WALKING)
        feet = walker.feet_m()
        if last:
            worst = max([worst] + [math.dist(a, b) for a, b in zip(feet, last, strict=True)])
        last = feet
    return worst


@pytest.mark.parametrize(("rate_hz", "ticks"), [(20, 4000), (50, 6000), (500, 6000)])
def test_no_foot_jumps_whatever_is_commanded(rate_hz, ticks):
    walker = in_state(n.STANDING, rate_hz)
    assert restless_feet(walker, ticks, 9) <= foot_step_limit_m(walker)


def test_the_jump_test_sees_a_planted_jump():
    walker = in_state(n.WALKING, 500)
    walker.ticks(20)
    before = walker.feet_m()
    for step in walker.planner.steps.legs:
        step.x += 6000 << 8
    walker.tick()
    assert max(math.dist(a, b) for a, b in zip(before, walker.feet_m(), strict=True)) > foot_step_limit_m(walker)


def drive(walker, ticks, seed):
    """Feed any words into both blocks; joints stay within limits while the gait drives them. Returns the states."""
    dice, states = random.Random(seed), set()
    low, high = limits_of(walker.params)
    for tick in range(ticks):
        if tick % 5 == 0:
            for block in (Row(walker.command), walker.sensed_row()):
                block[dice.randrange(len(block))] = any_word(dice)
            walker.command.mode = dice.choice((0, 1, 1, 2, 2, 2, 2, 2, 3, dice.randint(-9, 9)))
        flags = walker.planner.tick(walker.command, walker.sensed)
        states.add(walker.state)
        joints = list(walker.planner.joints)
        assert 0 <= flags < 1 << 14
        if walker.state in (n.STANDING, n.WALKING):
            assert all(a <= q <= b for a, q, b in zip(low, joints, high, strict=True))
        else:
            assert all(-32768 <= q <= 32767 for q in joints)
    return states


@pytest.mark.parametrize("name", ["caramelo", "parallel", "long-leg"])
def test_any_words_in_command_and_senses_are_survived(name):
    walker = Walker(name)
    walker.params.joint_speed_slow = walker.params.joint_speed_max.hip // 2  # fast, so that more of the time is walked
    states = drive(walker, 6000, 11)
    assert states >= {n.LIMP, n.RISING, n.STANDING, n.WALKING}


def test_unknown_modes_and_gaits_are_reported_and_replaced():
    walker = in_state(n.WALKING)
    gait = walker.planner.status.gait
    walker.command.gait = len(NAMES)
    assert walker.tick() & n.BAD_COMMAND
    walker.ticks(200)
    assert walker.planner.status.gait == gait
    walker.gait("one-by-one")
    walker.mode(17)
    assert walker.tick() & n.BAD_COMMAND
    walker.until(n.STANDING)


def test_balance_without_attitude_is_reported_and_fades():
    walker = in_state(n.STANDING)
    walker.command.balance = 1
    walker.sensed.tilt[0] = 600
    for _ in range(50):
        assert walker.tick() & n.NO_ATTITUDE == 0
    assert walker.planner.balanced_pose.roll < -100
    walker.sensed.valid.tilt = 0
    before = walker.planner.balanced_pose.roll
    assert walker.tick() & n.NO_ATTITUDE
    assert 0 < walker.planner.balanced_pose.roll - before <= walker.params.pose_slew.roll
    walker.ticks(200)
    assert walker.planner.balanced_pose.roll == 0


def test_an_unreachable_stance_is_flagged_and_held_at_the_limits():
    walker = in_state(n.STANDING)
    walker.params.pose_max.z = walker.params.pose_slew.z = 20000
    walker.command.pose.z = 20000
    assert walker.tick() & (TOO_FAR | TOO_NEAR | INSIDE_HIP)
    assert any(walker.planner.leg_flags)


def test_commands_are_limited_to_the_longest_stride():
    """Faster than the gait's stance allows is not walked; what is walked keeps the stride."""
    walker = Walker()
    walker.walk("paper-trot", 5.0)
    walker.ticks(600)
    assert walker.planner.speed.vx == walker.planner.gaits[0].speed_max.vx
    xs = []
    for _ in range(200):
        walker.tick()
        xs.append(walker.feet_m()[0][0])
    assert max(xs) - min(xs) <= walker.params.stride_max * walker.unit_m * 1.01


@pytest.mark.parametrize("gait", ["even-trot", "trot"])
def test_who_stands_has_no_leg_in_the_air(gait):
    """Also in the first tick after a walk, whose last feet have just come down."""
    walker = Walker()
    walker.walk(gait)
    walker.ticks(100)
    walker.mode(c.MODE_STAND)
    walker.until(n.STANDING, 60)
    walker.tick()
    assert walker.state == n.STANDING
    assert walker.swinging() == 0
