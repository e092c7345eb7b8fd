"""shared/planner/goals.py: no goal moves faster than its joint, no reading that stands alone moves any."""

import itertools
import random
from array import array

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host.lab.parity.probe.row import Row
from host.robot.file import find, read_toml
from host.robot.model import Robot
from host.robot.scale import core_params
from shared.gait.gaits import GAIT_NAMES, GAITS
from shared.planner import command as c
from shared.planner import status as n
from shared.planner.goals import READ_SURE, ReadingHistory, believe, follow_goals, joints_near
from shared.record import pack
from tests.float_twin import goals as twin

from .bars import ANGLES, WORD, any_word, integers
from .robots import block
from .walker import TABLE_GAITS, Walker

ROBOTS = ("caramelo", "parallel")
COUNT = 3  # values in a set of readings
STEP = 800


def motors(params, joints):
    """Return what the twelve motors turn: of a calf whose motor is on the body, thigh + calf."""
    made = list(joints)
    if params.coupled:
        for at in range(2, 12, 3):
            made[at] += made[at - 1]
    return made


def tops(params):
    """Return how far each motor turns in a tick, brad."""
    return pack(params.joint_speed_max) * 4


def too_fast(params, before, now):
    """Return the motors that would have to turn faster than they can."""
    pairs = zip(motors(params, before), motors(params, now), tops(params), strict=True)
    return [joint for joint, (a, b, top) in enumerate(pairs) if abs(a - b) > top]


def driven_from_the_body(ratio):
    """Return Caramelo with its calves' motors on the body, geared so that they are not as fast as the thighs'."""
    tables = read_toml(find("caramelo"))
    tables["calf_drive"] = {"motor_on": "body", "ratio": ratio}
    tables["gait"]["sag_compensation"] = 0.0  # of which a calf so geared would need too much
    return core_params(Robot.model_validate(tables))


DRIVES = {name: block(name) for name in ROBOTS}
DRIVES |= {f"body, {ratio:g}": driven_from_the_body(ratio) for ratio in (0.4, 0.9, 1.12283, 3.0)}


# --- sent


@pytest.mark.parametrize("name", DRIVES)
@settings(max_examples=100)
@given(st.data())
def test_goals_follow_as_fast_as_the_motors_turn_and_stay_between(name, data):
    params, wanted, start = DRIVES[name], data.draw(ANGLES), data.draw(ANGLES)
    joints = array("i", start)
    exact = twin.follow(wanted, start, pack(params.joint_speed_max), params.coupled)
    follow_goals(params, wanted, joints)
    assert list(joints) == exact
    assert too_fast(params, start, joints) == []
    assert all(min(a, b) <= q <= max(a, b) for a, b, q in zip(start, wanted, joints, strict=True))
    assert joints_near(params, exact, joints) == 1
    for _ in range(400):
        follow_goals(params, wanted, joints)
    assert list(joints) == list(wanted)


def test_a_motor_on_the_body_is_what_the_limit_is_for():
    """Thigh forward and calf back as far: its motor stands still, so only the thigh's speed counts."""
    params = block("parallel")
    top = params.joint_speed_max.thigh
    joints = array("i", [0] * 12)
    follow_goals(params, [0, 9 * top, -9 * top] * 4, joints)
    assert list(joints) == [0, top, -top] * 4
    joints = array("i", [0] * 12)
    follow_goals(params, [0, 9 * top, 9 * top] * 4, joints)
    assert list(joints) == [0, top, 0] * 4


@pytest.mark.parametrize("ratio", [0.4, 3.0])
def test_a_calf_at_its_limit_stays_there_while_the_thigh_moves(ratio):
    """It would be carried beyond it, by the difference of the two motors' speeds."""
    params = driven_from_the_body(ratio)
    _, thigh, calf = pack(params.joint_speed_max)
    for way in (1, -1):
        joints = array("i", [0] * 12)
        follow_goals(params, [0, 20000 * way, 0] * 4, joints)
        assert list(joints) == [0, min(thigh, calf) * way, 0] * 4


def test_near_is_within_a_tick_of_every_joint():
    params = block("caramelo")
    for joint, top in enumerate(tops(params)):
        for way, near in ((top, 1), (-top, 1), (top + 1, 0), (-top - 1, 0)):
            readings = [0] * 12
            readings[joint] = way
            assert joints_near(params, readings, [0] * 12) == near


def test_the_joints_speed_is_that_of_the_robot_file():
    """55 rpm at 12 V, through Caramelo's rod for the calf; 10 rad/s of Parallel's boards."""
    caramelo, parallel = block("caramelo"), block("parallel")
    assert pack(caramelo.joint_speed_max) == [1201, 1201, 1349]
    assert pack(parallel.joint_speed_max) == [2086, 2086, 2086]
    assert block("caramelo", 500).joint_speed_max.hip == 120
    assert block("caramelo", 500).read_step == 2 * block("caramelo", 50).read_step // 2


# --- believed


def sets(readings):
    """Return lists of sets of readings: near each other mostly, some of them anywhere."""
    near = integers(-STEP // 2, STEP // 2)
    return st.lists(st.lists(st.one_of(near, near, near, WORD), min_size=COUNT, max_size=COUNT), max_size=readings)


def taken(readings, more=2):
    """Return what is believed and the answer after each set; the ``more`` values behind it are no part of it."""
    believed, past, found = array("i", [0] * (COUNT + more)), ReadingHistory(), []
    for one in readings:
        answer = believe(list(one) + [9] * more, COUNT, STEP, believed, past)
        found.append((answer, list(believed[:COUNT])))
        assert list(believed[COUNT:]) == [0] * more
        assert answer < 0 or past.state >= READ_SURE
    return found


@settings(max_examples=300)
@given(sets(40))
def test_belief_is_the_twins(readings):
    believer = twin.Believer(STEP)
    for (answer, believed), one in zip(taken(readings), readings, strict=True):
        assert answer == believer.take([max(-32768, min(32767, reading)) for reading in one])
        assert believed == believer.believed


@settings(max_examples=200)
@given(integers(2, 20), integers(0, COUNT - 1), WORD)
def test_one_odd_reading_counts_nothing(tick, place, value):
    plain = [[100, 20 * at, -5] for at in range(24)]
    odd = [list(one) for one in plain]
    odd[tick][place] = value
    for at, ((answer, believed), (_, undisturbed)) in enumerate(zip(taken(odd), taken(plain), strict=True)):
        assert believed[:place] + believed[place + 1 :] == undisturbed[:place] + undisturbed[place + 1 :]
        assert abs(believed[place] - undisturbed[place]) <= STEP
        assert answer in ((0, 1) if at == tick else (-1,) if at == 0 else (0,))


def test_what_lasts_counts_from_its_second_tick_on():
    found = taken([[0, 0, 0], [0, 0, 0], [0, 9000, 0], [0, 9010, 0], [0, 9020, 0]])
    assert [answer for answer, _ in found] == [-1, 0, 1, 0, 0]
    assert [believed[1] for _, believed in found] == [0, 0, 0, 9010, 9020]


def test_the_same_odd_reading_again_much_later_is_odd_again():
    found = taken([[0, 0, 0], [0, 0, 0], [0, 9000, 0], [0, 0, 0], [0, 9000, 0], [0, 0, 0]])
    assert [believed[1] for _, believed in found] == [0] * 6
    found = taken([[0, 0, 0], [0, 0, 0], [0, 9000, 0], [7000, 0, 0], [0, 9000, 0], [0, 0, 0]])
    assert [believed for _, believed in found] == [[0, 0, 0]] * 6


def test_after_ten_odd_sets_in_a_row_nothing_is_known_until_two_agree():
    noise = [[0, 5000 * (-1) ** at, 0] for at in range(11)]
    noise = [[0, value + 3000 * at % 20000, 0] for at, (_, value, _) in enumerate(noise)]
    answers = [answer for answer, _ in taken([[0, 0, 0]] * 2 + noise + [[0, 400, 0]] * 2)]
    assert answers == [-1, 0] + [1] * 10 + [-1, -1, 0]


# --- the planner throughout


def test_before_the_joints_are_known_the_goals_are_what_was_read_and_it_stays_limp():
    walker, lying = Walker(), [300 * joint - 2000 for joint in range(12)]
    walker.mode(c.MODE_STAND)
    for sensed in ([7000] * 12, lying):  # the first reading is odd, the second is not that of the first
        walker.sensed.joints[:] = sensed
        assert walker.planner.tick(walker.command, walker.sensed) == n.NO_JOINTS | n.NOT_DRIVEN
        assert list(walker.planner.joints) == sensed
    assert walker.planner.tick(walker.command, walker.sensed) == 0
    assert walker.state == n.RISING
    assert list(walker.planner.move.start) == lying


def wild_command(walker, dice):
    """Command anything: modes, gaits, speeds and poses at the ends of the sliders or beyond, any words."""
    command, params = walker.command, walker.params
    command.mode = dice.choice((c.MODE_WALK,) * 6 + (c.MODE_STAND, c.MODE_STAND, c.MODE_SIT, c.MODE_LIMP, 9))
    command.gait = dice.choice((-1, *range(len(GAITS)), len(GAITS)))
    command.balance = dice.randrange(2)
    command.height = dice.choice((0, 0, 6000, any_word(dice)))
    for axis in range(3):
        top = params.speed_max[axis]
        command.speed[axis] = dice.choice((0, top, -top, dice.randint(-top, top), any_word(dice)))
    for axis in range(6):
        top = params.pose_max[axis]
        command.pose[axis] = dice.choice((0, top, -top, dice.randint(-top, top), any_word(dice)))


def wild_senses(walker, dice):
    """Joints somewhere about the goals, tilts that wander; now and then glitches, stuck and missing values."""
    sensed = walker.sensed
    for joint in range(12):
        sensed.joints[joint] = walker.planner.joints[joint] + dice.randint(-300, 300)
    for axis, tilt in enumerate(sensed.tilt):
        sensed.tilt[axis] = max(-9000, min(9000, tilt)) + dice.randint(-400, 400) - (tilt >> 6)
    if dice.randrange(8) == 0:
        row = walker.sensed_row()
        row[dice.randrange(len(row))] = any_word(dice)
    for known in ("joints", "tilt", "turned"):
        setattr(sensed.valid, known, int(dice.random() < 0.97))


def lived(name, rate_hz, ticks, seed):
    """Let a planner live with anything; return the states it was in, and (tick, state, motors) that were too fast."""
    walker, dice = Walker(name, rate_hz), random.Random(seed)
    walker.params.joint_speed_slow = walker.params.joint_speed_max.hip // 2  # up fast: more of the time is walked
    walker.stand()
    states, wrong, before = set(), [], list(walker.planner.joints)
    for tick in range(ticks):
        if tick % 40 == 0 or dice.randrange(60) == 0:
            wild_command(walker, dice)
        wild_senses(walker, dice)
        walker.planner.tick(walker.command, walker.sensed)
        states.add(walker.state)
        now = list(walker.planner.joints)
        if too_fast(walker.params, before, now):
            wrong.append((tick, walker.state, too_fast(walker.params, before, now)))
        before = now
    return states, wrong


@pytest.mark.parametrize(("name", "rate_hz", "ticks"), [
    ("caramelo", 50, 6000), ("parallel", 50, 6000), ("caramelo", 20, 2000), ("parallel", 500, 4000),
    ("long-leg", 50, 2000), ("no-offset", 50, 2000),
])  # fmt: skip
def test_no_goal_is_faster_than_its_joint_whatever_is_commanded_and_sensed(name, rate_hz, ticks):
    states, wrong = lived(name, rate_hz, ticks, 7)
    assert wrong == []
    assert states >= {n.LIMP, n.RISING, n.STANDING, n.WALKING, n.SITTING}


def test_the_speed_test_sees_a_planted_jump(monkeypatch):
    from shared.planner import planner

    def at_once(params, wanted, joints):
        joints[:] = array("i", wanted)

    monkeypatch.setattr(planner, "follow_goals", at_once)
    assert lived("caramelo", 50, 1500, 7)[1] != []


def pair_in(state, gait, ticks):
    """Return two alike walkers in a state, in the middle of it."""
    pair = []
    for _ in range(2):
        walker = Walker()
        if state == n.LIMP:
            walker.ticks(4)
        elif state == n.RISING:
            walker.mode(c.MODE_STAND)
            walker.ticks(ticks)
        else:
            walker.walk(gait)
            if state != n.STANDING:
                walker.ticks(60 + ticks)
            if state in (n.SITTING, n.SEATED):
                walker.mode(c.MODE_SIT)
                walker.until(state)
                walker.ticks(ticks % 9)
        assert walker.state in (state, n.WALKING)
        pair.append(walker)
    return pair


def glitched(state, gait, then, seed):
    """Return by how much one odd reading moved any goal in the 60 ticks after it, brad, and if it was told."""
    dice = random.Random(seed)
    plain, odd = pair_in(state, gait, dice.randrange(6, 50))
    readings = Row(odd.sensed.tilt, odd.sensed.joints)
    readings[dice.randrange(len(readings))] += dice.choice((-1, 1)) * dice.randint(4000, 30000)
    told, worst = 0, 0
    for _ in range(60):
        for walker in (plain, odd):
            if then is not None:
                walker.mode(then)
        plain.tick()
        told |= odd.tick() & n.ODD_READING
        odd.sensed.tilt[:] = 0, 0
        worst = max(worst, *(abs(a - b) for a, b in zip(plain.planner.joints, odd.planner.joints, strict=True)))
    return worst, told


MOVES = ((n.LIMP, c.MODE_STAND), (n.RISING, c.MODE_SIT), (n.RISING, None), (n.STANDING, c.MODE_SIT), (n.SITTING, None),
         (n.SITTING, c.MODE_STAND), (n.SEATED, c.MODE_STAND), (n.STANDING, c.MODE_STAND), (n.WALKING, None))


@pytest.mark.parametrize(("state", "then"), MOVES)
@pytest.mark.parametrize("gait", ["paper-trot", "even-trot"])
def test_one_odd_reading_moves_nothing(state, then, gait):
    for seed in range(6):
        worst, told = glitched(state, gait, then, seed)
        assert told
        assert worst <= (2 if then == c.MODE_STAND and state == n.LIMP else 0)


@pytest.mark.parametrize("gait", ["trot", "crawl"])
def test_one_odd_reading_hardly_moves_what_walks_by_feeling(gait):
    """What is believed instead is the reading before: a tick's way of the joint, 2 degrees at most in the goals."""
    for seed in range(8):
        assert glitched(n.WALKING, gait, None, seed)[0] <= 364


# --- poses out of reach


def pose_at(walker, ends):
    """Command each slider at an end, or in the middle: 1, -1, 0."""
    for axis, end in enumerate(ends):
        walker.command.pose[axis] = end * walker.params.pose_max[axis]


def held_short(name, ends):
    """Return if a robot standing with its sliders there is cut short; which it tells, and stands still to the bit."""
    walker = Walker(name)
    walker.stand()
    pose_at(walker, ends)
    walker.ticks(100)
    still = list(walker.planner.joints)
    walker.ticks(50)
    assert list(walker.planner.joints) == still
    flags, arrived = walker.tick(), pack(walker.planner.pose) == pack(walker.command.pose)
    assert bool(flags & n.POSE_HELD) == (not arrived)
    assert flags & 0x3F == 0  # nothing out of reach, no joint at its limit
    return not arrived


CORNERS = list(itertools.product((0, 1, -1), repeat=6))
PAIRS = [ends for ends in CORNERS if sum(map(abs, ends)) == 2]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("corners", [PAIRS, pytest.param(CORNERS, marks=pytest.mark.slow)], ids=["pairs", "all"])
def test_a_pose_out_of_reach_is_approached_as_far_as_it_goes_and_told(name, corners):
    """No leg beyond its reach, standing still to the bit, told if cut short."""
    cut = [held_short(name, ends) for ends in corners]
    assert any(cut)


def test_a_held_pose_follows_the_next_command():
    walker = Walker()
    walker.stand()
    walker.command.pose.z, walker.command.pose.pitch = 5000, walker.params.pose_max.pitch
    walker.ticks(150)
    assert walker.tick() & n.POSE_HELD
    assert 0 < walker.planner.pose.pitch < walker.command.pose.pitch
    walker.command.pose.pitch = 500
    walker.ticks(150)
    assert walker.tick() == 0
    assert pack(walker.planner.pose)[2:5] == [5000, 0, 500]


@pytest.mark.parametrize("after", range(4))
def test_a_pose_that_is_given_up_at_once_is_left(after):
    """In whichever tick it is: while the body still steps back from what a trunk that lags made of the balance, too."""
    walker = Walker()
    walker.stand()
    walker.command.balance = 1
    pose_at(walker, (0, 0, 1, 1, 1, 0))
    while not walker.tick() & n.POSE_HELD:
        continue
    walker.ticks(after)
    pose_at(walker, (0, 0, 0, 0, 0, 0))
    walker.ticks(10)
    walker.command.balance = 0
    walker.ticks(150)
    assert walker.tick() == 0
    assert pack(walker.planner.pose) == [0] * 6


def largest_step(walker, ticks):
    """Walk on; return the largest step that any joint would have to take in a tick, before its speed is limited."""
    worst, last = 0, list(walker.planner.goal)
    for _ in range(ticks):
        walker.tick()
        now = list(walker.planner.goal)
        worst = max(worst, *(abs(a - b) for a, b in zip(last, now, strict=True)))
        last = now
    return worst


def walking_at(name, gait, ends, balance):
    """Return the largest step of a walk that begins with the sliders there."""
    walker = Walker(name)
    walker.walk(gait)
    walker.command.balance = balance
    pose_at(walker, ends)
    return largest_step(walker, 150)


@pytest.mark.parametrize(("gait", "most_deg"), [*((gait, 20) for gait in TABLE_GAITS), ("trot", 30)])
def test_with_the_sliders_at_their_ends_a_walk_is_no_faster_than_without(gait, most_deg):
    """What is wanted, before its speed is limited, no longer jumps (it was 140); the trot leads what drives lag."""
    dice = random.Random(3)
    for _ in range(12):
        assert walking_at("caramelo", gait, dice.choice(CORNERS), dice.randrange(2)) <= most_deg * 65536 // 360


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("gait", GAIT_NAMES)
def test_no_corner_of_the_sliders_makes_a_walk_faster_than_without(name, gait):
    """All 729 of them, balance on."""
    worst = max((walking_at(name, gait, ends, 1), ends) for ends in CORNERS)
    print(f"{name}, {gait}: at most {worst[0] * 360 / 65536:.1f} degrees a tick, at {worst[1]}")
    assert worst[0] <= 20 * 65536 // 360
