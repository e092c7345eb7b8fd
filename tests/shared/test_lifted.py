"""shared/planner/lifted.py against the rule as a sentence has it, in seconds: who is lifted, and when it is over."""

import random

import pytest

from shared.planner import command as c
from shared.planner import status as n
from shared.planner.lifted import put_down, watch_weight
from shared.sense.odometry import FELT

from .walker import Walker

GONE_S, BACK_S, TICK_S = 0.25, 2.0, 0.02


class Rule:
    """The rule, told by when what was felt last changed."""

    def __init__(self):
        self.carries = self.lifted = False
        self.since_s = None

    def feel(self, time_s, carried):
        feels = carried >= FELT
        if feels == self.carries:
            self.since_s = None
            return
        self.since_s = time_s if self.since_s is None else self.since_s
        if time_s + TICK_S - self.since_s > (BACK_S if feels else GONE_S) + 1e-9:
            self.carries, self.since_s = feels, None
            self.lifted = self.lifted or not feels

    def told(self, mode):
        if mode in (c.MODE_LIMP, c.MODE_SIT) or (mode == c.MODE_STAND and self.carries):
            self.lifted = False


def weights(dice, count):
    """Yield what the feet carry: nothing, little, the weight, for ticks or seconds."""
    while count > 0:
        carried = dice.choice((0, FELT - 1, FELT, 50))
        for _ in range(min(count, dice.choice((1, 5, 12, 13, 14, 30, 99, 100, 101, 102, 300)))):
            count -= 1
            yield carried


@pytest.mark.parametrize("seed", range(8))
def test_who_is_lifted(seed):
    dice, rule, walker = random.Random(seed), Rule(), Walker("caramelo", 50)
    walker.stand()
    planner, began = walker.planner, 0
    for tick, carried in enumerate(weights(dice, 20000)):
        mode = dice.choice((c.MODE_WALK,) * 300 + (c.MODE_STAND,) * 2 + (c.MODE_SIT, c.MODE_LIMP))
        planner.status.flags = 0
        assert put_down(planner, mode) == int(bool(planner.status.flags & n.LIFTED))
        rule.told(mode)
        planner.odometry.carried = carried
        was = rule.lifted
        rule.feel(tick * TICK_S, carried)
        assert watch_weight(planner) == int(rule.lifted)
        assert planner.status.carries == int(rule.carries)
        if rule.lifted and not was:
            assert (planner.status.state, bool(planner.status.flags & n.LIFTED)) == (n.RISING, True)
            began += 1
    assert began > 5


def loaded(walker, weight):
    """Tick; the joints sag under ``weight`` of the robot's own, all legs alike."""
    planner = walker.planner
    walker.tick()
    limb = walker.params.legs[0]
    drop = limb.thigh_length  # thigh and calf in the rest pose: each about 45 degrees to the ground
    sag = 256 * 4096 // 4 * drop // (4096 * walker.params.stiff_q8[1]) * weight
    for leg in range(4):
        walker.sensed.joints[3 * leg + 1] = planner.joints[3 * leg + 1]
        walker.sensed.joints[3 * leg + 2] = round(planner.joints[3 * leg + 2] - limb.knee * -1 * sag)


def test_felt_and_missed():
    """The whole planner, its feet's loads made of the joints' errors: it stands, is lifted, is put down."""
    walker = Walker()
    walker.stand()
    walker.sensed.valid.turned = 1
    for _ in range(150):
        loaded(walker, 1.0)
    assert walker.planner.status.carries
    walker.mode(c.MODE_WALK)
    walker.gait("trot")
    for _ in range(20):
        loaded(walker, 0.0)
    assert walker.planner.status.lifted
    place, goals = list(walker.planner.odometry.place), None
    for tick in range(200):
        walker.speed(0.2)
        loaded(walker, 0.0)
        assert walker.planner.status.flags & n.LIFTED
        assert list(walker.planner.odometry.place) == place
        if tick > 100:
            assert goals == list(walker.planner.joints)
        goals = list(walker.planner.joints)
    for _ in range(150):
        loaded(walker, 1.0)
    assert walker.planner.status.lifted, "it does not go on by itself"
    walker.mode(c.MODE_STAND)
    loaded(walker, 1.0)
    assert not walker.planner.status.lifted
    walker.mode(c.MODE_WALK)
    loaded(walker, 1.0)
    loaded(walker, 1.0)
    assert walker.state == n.WALKING


def test_who_never_felt_its_weight_walks_in_the_air():
    walker = Walker()
    walker.walk("trot", 0.1)
    assert walker.ticks(500) & n.LIFTED == 0
    assert walker.state == n.WALKING
