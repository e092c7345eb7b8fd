"""Trot and crawl take over from each other as in the float twin: the same stage, reason and state in every tick."""

import random
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.crawl import state as at
from shared.gait.table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT
from shared.planner import command as c
from shared.planner import handover, mover_choice, movers, planner, retreat, walk_crawl
from shared.planner import status as n
from shared.planner.command import Command
from shared.record import pack, unpack
from tests.float_twin import crawl_exchange as twin
from tests.float_twin.doubt import Doubt
from tests.float_twin.si import planner_si, scaled

from .robots import block
from .walker import BACK, NAMES, OFF, ON, Walker, phase

PATIENCE_S = 4
PATIENCE = 7  # swings in a row of both front or both hind feet
HELD = (0, 50 * PATIENCE_S, 50 * PATIENCE_S + 1, 4000)  # ticks
ROWS = ([0, 0],) * 3 + ([PATIENCE - 1, PATIENCE - 1], [PATIENCE, 0], [0, PATIENCE], [-100, 100])
MOVE, CHOOSE, TICK = planner.move, planner.choose_mover, planner.tick_mover


class Pair:
    """A planner, and the twin of its decisions that is told what the planner knows."""

    def __init__(self, rate_hz=50, walker=None):
        self.walker = walker or Walker(rate_hz=rate_hz)
        self.robot = planner_si(self.walker.params)
        self.twin = twin.Exchange(self.robot, len(NAMES), Doubt())
        self.seen = set()

    @property
    def status(self):
        return self.walker.planner.status

    def command(self, block: Command):
        """Return a command for the twin."""
        speed = scaled(block.speed, self.robot.speed_unit)
        return SimpleNamespace(walk=block.mode == c.MODE_WALK, gait=block.gait, speed=speed)

    def known(self, sensed):
        """Return what the planner knows now."""
        robot, numbers = self.walker.planner, self.status
        return SimpleNamespace(
            joints_ok=sensed.valid.joints,
            attitude_ok=sensed.valid.tilt,
            fallen=numbers.fallen,
            standing=numbers.state == n.STANDING,
            walked=numbers.gait,
            held=numbers.mover == MOVER_TROT and self.held_up(robot.trot),
            moved=robot.trot.state.measured_speed.x * self.robot.unit_m / 256,
            known=robot.sensing.known,
        )

    def held_up(self, trot):
        """Return whether it was held up for too long, or by a wall."""
        return trot.state.stuck_ticks > PATIENCE_S * self.robot.rate_hz or max(trot.held_up_in_row) >= PATIENCE

    def move(self, robot, command, sensed):
        """Stand in for shared.planner.planner.move: one tick of the mover whose turn it is."""
        flags, self.status.flags, self.standing = self.status.flags, 0, None
        answer = MOVE(robot, command, sensed)
        if self.standing is not None:
            if self.twin.stage == twin.OFF:
                self.handed_over()
            self.compare(self.standing)
        self.status.flags |= flags
        return answer

    def choose(self, robot, command, sensed):
        """Stand in for choose_mover: both decide, but of a crawl that has begun."""
        if self.status.mover == MOVER_CRAWL:
            return CHOOSE(robot, command, sensed)
        wanted, known = self.command(command), self.known(sensed)
        answer = CHOOSE(robot, command, sensed)
        assert (answer == MOVER_CRAWL) == self.twin.takes(wanted, known)
        movers.change_mover(robot, answer)
        self.compare(known.standing)
        return answer

    def tick_mover(self, robot, command, sensed):
        """Stand in for tick_mover: of the crawl both take the tick."""
        if self.status.mover != MOVER_CRAWL:
            return TICK(robot, command, sensed)
        wanted, known = self.command(command), self.known(sensed)
        crawl = robot.crawl
        before = SimpleNamespace(even_landings=crawl.ground.even_landings)
        events = crawl.ground.landings
        answer = TICK(robot, command, sensed)
        known.known = robot.sensing.known
        was = self.twin.stage
        self.twin.begin_crawl(known)
        self.standing, self.twin.walked = known.standing, known.walked
        if self.twin.stage == twin.ON and not self.twin.blind:
            reason = self.twin.why_end(wanted, before if was == twin.ON else SimpleNamespace(even_landings=0))
            self.standing = self.twin.end_crawl(wanted, known, reason, crawl.stage.stage == at.REST)
            assert reason or crawl.ground.landings in (events, events + 1, 0)
            assert self.swings(crawl)
        return answer

    def swings(self, crawl):
        """Return whether the planner says which leg is in the air."""
        bits = sum(1 << leg for leg in range(4) if not crawl.support.stance[leg])
        return self.status.swinging == bits and self.status.margin == crawl.support.margin

    def handed_over(self):
        """The trot begins from rest, with nothing held against it."""
        robot = self.walker.planner
        assert pack(robot.speed) == [0, 0, 0]
        assert (self.status.mover, self.status.state) == (MOVER_TROT, n.WALKING)
        assert robot.trot.state.stuck_ticks == 0
        assert list(robot.trot.held_up_in_row) == [0, 0]

    def compare(self, standing):
        """The same stage, reason, state, gait and flag."""
        status = self.status
        core = phase(self.walker.planner), status.reason, status.state == n.STANDING, status.gait
        assert core == (self.twin.stage, self.twin.reason, standing, self.twin.walked)
        assert bool(status.flags & n.BLIND) == self.twin.blind
        self.seen.add((self.twin.stage, self.twin.reason))

    def tick(self):
        """One tick of the planner; whoever sits, rises or is limp has forgotten the crawl."""
        self.walker.tick()
        if self.walker.state not in (n.STANDING, n.WALKING):
            self.twin.stage = twin.OFF


@pytest.fixture
def spied(monkeypatch):
    """Return what makes a pair and lets it look over the planner's shoulder."""

    def make(rate_hz=50):
        pair = Pair(rate_hz)
        monkeypatch.setattr(planner, "move", pair.move)
        monkeypatch.setattr(planner, "choose_mover", pair.choose)
        monkeypatch.setattr(planner, "tick_mover", pair.tick_mover)
        pair.walker.stand()
        return pair

    return make


MODES = (c.MODE_WALK,) * 12 + (c.MODE_STAND, c.MODE_SIT)
GAITS = (twin.CRAWL,) * 3 + (twin.TROT,) * 6 + (0, 7)
SPEEDS_SI = ((0.05, 0.0, 0.0),) * 6 + (
    (0.05, 0.04, 0.0),
    (0.03, 0.0, 0.1),
    (0.0, 0.0, 0.0),
    (0.02, 0.04, 0.0),
    (-0.05, 0.0, 0.0),
)


def trouble(pair, dice):
    """Draw a command now and then, and senses, swings held up and even ground."""
    block, sensed, numbers = pair.walker.command, pair.walker.sensed, pair.status
    if dice.random() < 0.006:
        block.mode, block.gait = dice.choice(MODES), dice.choice(GAITS)
        pair.walker.speed(*dice.choice(SPEEDS_SI))
    sensed.valid.joints = int(dice.random() > 0.002)
    sensed.valid.tilt = int(dice.random() > 0.002)
    if dice.random() < 0.01 and numbers.mover == MOVER_TROT:
        pair.walker.planner.trot.state.stuck_ticks = dice.choice(HELD)
        pair.walker.planner.trot.held_up_in_row[:] = dice.choice(ROWS)
    if dice.random() < 0.3 and phase(pair.walker.planner) == ON:
        pair.walker.planner.crawl.ground.even_landings = dice.choice((0, 15, 16, 20))


def restless(spied, seed):
    """Drive for 100 s, both deciding; return the stages met, each with the reason of the last exchange."""
    pair, dice = spied(), random.Random(seed)
    for _ in range(5000):
        trouble(pair, dice)
        pair.tick()
    return pair.seen


def all_restless(spied):
    """Drive three times; return all stages met, likewise."""
    return set().union(*(restless(spied, seed) for seed in range(3)))


def test_a_restless_driver_gets_the_same_exchanges(spied):
    """Feet that never feel ground give up and stand in the air: enough for the decisions, and every leg rests."""
    seen = all_restless(spied)
    assert {stage for stage, _ in seen} == {twin.OFF, twin.READY, twin.ON, twin.BACK}
    assert {reason for stage, reason in seen if stage == twin.OFF} >= {twin.COMMAND, twin.EVEN}


def near(value):
    """Return a strategy of integers at and around +-value."""
    return st.sampled_from([sign * value + step for sign in (-1, 1) for step in (-1, 0, 1)])


PARAMS = block("caramelo")
TURN = PARAMS.speed_max.wz // 12
SPEEDS = st.tuples(
    st.one_of(st.integers(-2, 2), st.just(30000)), st.one_of(near(30000), near(1), st.just(0)), st.one_of(near(TURN))
)
COMMANDS = st.tuples(st.sampled_from((c.MODE_WALK,) * 4 + (c.MODE_STAND,)), st.sampled_from((2, 1, 1, 0, -1, 5)))
TROTS = st.fixed_dictionaries(
    {
        "state": st.sampled_from((n.STANDING, n.WALKING)),
        "gait": st.sampled_from((1, 1, 2, 0)),
        "fallen": st.sampled_from((0, 0, 0, 1)),
        "backing_off": st.sampled_from((0, 0, 1)),
    }
)
SHARED_WALKER = Walker()


def put(drawn, speed, command):
    """Return a pair whose planner is at a point that was drawn, and its command."""
    pair = Pair(walker=SHARED_WALKER)
    robot, block = pair.walker.planner, pair.walker.command
    for name, value in drawn.items():
        setattr(robot.status, name, value)
    robot.gait = robot.gaits[drawn["gait"]]
    robot.status.mover = MOVER_TROT if drawn["gait"] else MOVER_TABLE
    robot.status.reason, robot.status.flags, pair.twin.stage = 0, 0, BACK if drawn["backing_off"] else OFF
    block.mode, block.gait = command
    unpack(block.speed, speed)
    return pair, robot, block


@settings(max_examples=1500)
@given(TROTS, SPEEDS, COMMANDS, st.sampled_from((3, 3, 3, 1, 2)), st.sampled_from(HELD), st.sampled_from(ROWS))
def test_the_crawl_begins_for_the_same_reason_at_any_point(drawn, speed, command, senses, held, rows):
    pair, robot, block = put(drawn, speed, command)
    before, sensed = robot.status.mover, pair.walker.sensed
    sensed.valid.joints, sensed.valid.tilt = senses & 1, senses >> 1
    retreat.retreat_start(robot.retreat)
    pair.twin.retreat = twin.Retreat(pair.robot, Doubt())
    robot.trot.state.stuck_ticks, robot.trot.held_up_in_row[:], robot.speed.vx = held, rows, 99
    pair.choose(robot, block, sensed)
    ended = before == MOVER_TROT and robot.status.mover != MOVER_TROT
    assert robot.speed.vx == (0 if ended or robot.status.mover == MOVER_CRAWL else 99)


@settings(max_examples=600)
@given(TROTS, SPEEDS, COMMANDS, st.sampled_from((0, 15, 16, 17)))
def test_the_crawl_ends_for_the_same_reason_at_any_point(drawn, speed, command, even):
    pair, robot, block = put(drawn, speed, command)
    robot.crawl.ground.even_landings = even
    wanted = pair.command(block)
    pair.twin.walked = drawn["gait"]
    assert walk_crawl.end_reason(robot, block) == pair.twin.why_end(wanted, SimpleNamespace(even_landings=even))
    assert robot.status.gait == pair.twin.walked


@settings(max_examples=60)
@given(st.integers(0, 1 << 20), st.sampled_from((20, 50, 333)), st.booleans())
def test_backing_off_is_the_twins_tick_by_tick(seed, rate_hz, stuck):
    """Odometry that stutters, a trot that stands and walks again: the same speed, and the end in the same tick."""
    dice, params = random.Random(seed), block("caramelo", rate_hz)
    robot = planner_si(params)
    doubt = Doubt()
    back, state, told = twin.Retreat(robot, doubt), retreat.Retreat(), Command()
    retreat.retreat_start(state)
    command = Command()
    unpack(command, [dice.randint(-9999, 9999) for _ in pack(command)])
    for tick in range(9 * rate_hz):
        most = params.speed_max.vx
        moved = dice.randint(-most // 3, most // 3 if stuck else most // 9)
        steady = tick > 6 * rate_hz or dice.random() < 0.999  # the last time it stands it stands long enough
        standing = int(tick % (2 * rate_hz) > rate_hz and steady)
        doubt.begin()
        speed, done = back.step(moved * robot.unit_m / 256, standing)
        assert retreat.retreat_step(params, command, moved, standing, state, told) == int(done)
        if doubt.count:
            back.ends = bool(state.stopping)
        assert told.speed.vx * robot.unit_m / 256 == pytest.approx(speed, abs=1.1 * robot.unit_m / 256)
        assert (told.speed.vy, told.speed.wz) == (0, 0)
        assert told.gait == command.gait
        assert pack(told)[5:] == pack(command)[5:]  # pose, balance, height
        if done:
            return
    assert stuck or not back.ends


@settings(max_examples=60)
@given(st.lists(st.integers(-32768, 32767), min_size=24, max_size=24), st.sampled_from((20, 50, 333)))
def test_goals_go_on_from_the_crawls_and_fade_to_the_trots(values, rate_hz):
    params, fade = block("caramelo", rate_hz), handover.Fade()
    sent, goals = values[:12], values[12:]
    ticks = handover.fade_start(params, fade, sent)
    assert abs(ticks - rate_hz / 2) <= 1
    for left in range(ticks, -3, -1):
        found = list(goals)
        handover.fade_out(fade, found)
        exact = [twin.faded(goal, old - goal, max(0, left), ticks) for goal, old in zip(goals, sent, strict=True)]
        assert max(abs(a - b) for a, b in zip(found, exact, strict=True)) <= 1


def test_a_decision_that_is_off_by_one_is_seen(spied, monkeypatch):
    """The comparison can fail: a crawl that stays on even ground, follows any command, or never tires of backing."""
    for module, name, wrong in (
        (mover_choice, "crawl_can_follow", lambda *_: 1),
        (mover_choice, "retreat_step", lambda *_: 0),
        (mover_choice, "held_up_for_good", lambda *_: 0),
    ):
        with monkeypatch.context() as planted:
            planted.setattr(module, name, wrong)
            with pytest.raises(AssertionError):
                all_restless(spied)
    monkeypatch.setattr(walk_crawl, "even_for_trot", lambda *_: 0)
    with pytest.raises(AssertionError):
        test_the_crawl_ends_for_the_same_reason_at_any_point()
