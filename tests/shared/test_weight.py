"""shared/planner/weight.py against the rule as a sentence has it, in seconds: who is lifted, and when it is over."""

import random

import pytest

from shared.crawl import state as stages
from shared.gait.table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT
from shared.planner import command as c
from shared.planner import status as n
from shared.planner.weight import carried_load_q12, stays_lifted, watch_weight
from shared.record import pack

from .walker import Walker

AVERAGE_S, TICK_S = 0.2, 0.02
BOUND = 0.03  # of the own weight, for loads of up to 16 of it


class Rule:
    """The rule in floats: weights are in own weights."""

    def __init__(self):
        self.felt = 0.0
        self.carries = self.lifted = self.posed = False

    def pose(self):
        """Take a tick in which the pose moves: what the feet carry is asked anew, of who carried before always."""
        self.felt = 0.0
        self.carries, self.posed = False, self.carries or self.posed

    def feel(self, carried, risen, stands, rounded):
        """Take a tick; return whether it is lifted in it. ``risen``: it has risen just now. ``stands``: it does.

        ``rounded`` is what integers felt: it decides where that is too near to a limit for floats to contradict.
        """
        share = 1.0 if risen and not self.carries else TICK_S / (AVERAGE_S + TICK_S)
        self.felt += (carried - self.felt) * share
        assert rounded == pytest.approx(self.felt, abs=BOUND)
        if not self.carries:
            self.carries = rounded >= 0.5 and (risen or stands or self.posed)
            self.posed = self.posed and not self.carries
        elif rounded < 0.25:
            self.felt, self.carries, self.lifted = 0.0, False, True  # the move to the stance begins, nothing felt
            return True
        return False

    def told(self, mode):
        if mode in (c.MODE_LIMP, c.MODE_SIT) or (mode == c.MODE_STAND and self.carries):
            self.lifted = False


def carries(rule):
    return n.CARRIES if rule.carries else n.POSED if rule.posed else n.CARRIES_NOT


def weights(dice, count):
    """Yield what the feet carry, in own weights: nothing, little, the weight, nonsense; for ticks or seconds."""
    while count > 0:
        carried = dice.choice((0.0, 0.1, 0.6, 1.0, 1.0, dice.uniform(-16, 16)))
        for _ in range(min(count, dice.choice((1, 5, 12, 14, 30, 101, 120, 300)))):
            count -= 1
            yield carried


@pytest.mark.parametrize("seed", range(8))
def test_who_is_lifted(seed):
    """The evened weight within 1/100 of an own weight of the rule's in floats; all decisions the same."""
    dice, rule, walker = random.Random(seed), Rule(), Walker("caramelo", 50)
    walker.stand()
    planner, began = walker.planner, 0
    status = planner.status
    status.feet_load_q12 = status.carries_weight = 0
    for weight in weights(dice, 20000):
        mode = dice.choice((c.MODE_WALK,) * 300 + (c.MODE_STAND,) * 2 + (c.MODE_SIT, c.MODE_LIMP))
        status.flags = 0
        if dice.random() < 0.01:
            status.state = dice.choice((n.STANDING, n.WALKING))
        assert stays_lifted(planner, mode) == int(bool(status.flags & n.LIFTED))
        rule.told(mode)
        planner.odometry.carried_q12 = round(4096 * weight)
        risen, felt = dice.random() < 0.01, status.feet_load_q12
        planner.sensing.known = walker.params.delay_ticks + 4 if risen else 100
        stands = status.state == n.STANDING
        status.pose_moves = int(dice.random() < 0.003)
        watch_weight(planner)
        if status.pose_moves:
            rule.pose()
            assert status.feet_load_q12 == 0
            continue
        share_q10 = 1024 if risen and not rule.carries else 5120 // 55  # at 50 Hz
        told = min(max(weight, -1.0), 2.0)  # a tick tells no more
        begins = rule.feel(told, risen, stands, (felt + ((round(4096 * told) - felt) * share_q10 >> 10)) / 4096)
        if begins:
            assert (status.state, bool(status.flags & n.LIFTED)) == (n.RISING, True)
            began += 1
        assert status.feet_load_q12 / 4096 == pytest.approx(rule.felt, abs=BOUND)
        assert (status.carries_weight, status.lifted) == (carries(rule), int(rule.lifted))
    assert began > 5


@pytest.mark.parametrize("mover", [MOVER_TABLE, MOVER_TROT, MOVER_CRAWL])
@pytest.mark.parametrize("stage", range(stages.STILL + 1))
def test_a_foot_that_the_crawl_lowers_carries_what_it_presses(mover, stage):
    """At most the own weight: it may bear most of the robot before it is told to stand. A pull counts nothing."""
    planner = Walker("caramelo", 50).planner
    planner.status.mover, planner.crawl.stage.stage, planner.crawl.stage.leg = mover, stage, 2
    planner.odometry.carried_q12 = 500
    lowers = mover == MOVER_CRAWL and stage in (stages.HANG, stages.LOWER)
    for force, pressed in ((-16383, 0), (-1, 0), (0, 0), (900, 900), (4096, 4096), (16383, 4096)):
        planner.sensing.force_q12[:] = [7000, 7000, force, 7000]
        assert carried_load_q12(planner) == 500 + (pressed if lowers else 0)


def loaded(walker, weight):
    """Tick; the joints sag under ``weight`` of the robot's own, all legs alike."""
    planner = walker.planner
    walker.tick()
    limb = walker.params.legs[0]
    drop = limb.thigh_length  # thigh and calf in the rest pose: each about 45 degrees to the ground
    sag = 256 * 4096 // 4 * drop // (4096 * walker.params.stiff_q8.thigh) * weight
    for leg in range(4):
        walker.sensed.joints[3 * leg + 1] = planner.joints[3 * leg + 1]
        walker.sensed.joints[3 * leg + 2] = round(planner.joints[3 * leg + 2] - limb.knee * -1 * sag)


def test_felt_and_missed():
    """The whole planner, its feet's loads made of the joints' errors: it rises, is lifted, is put down."""
    walker = Walker()
    walker.sensed.valid.turned = 1
    walker.mode(c.MODE_STAND)
    while walker.state != n.STANDING:
        loaded(walker, float(walker.state != n.LIMP))
    for _ in range(20):
        loaded(walker, 1.0)
    assert walker.planner.status.carries_weight == n.CARRIES
    walker.mode(c.MODE_WALK)
    walker.gait("trot")
    while not walker.planner.status.lifted:
        before = list(walker.planner.joints)
        loaded(walker, 0.0)
    gone = [abs(now - then) for now, then in zip(walker.planner.joints, before, strict=True)]
    assert max(gone) <= walker.params.joint_speed_slow  # slowly from its first tick on
    place, goals = pack(walker.planner.odometry.place), None
    for tick in range(200):
        walker.speed(0.2)
        loaded(walker, 0.0)
        assert walker.planner.status.flags & n.LIFTED
        assert pack(walker.planner.odometry.place) == place
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
