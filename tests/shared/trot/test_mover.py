"""The trot as a mover: stands, walks, stops, hands over, gives up, goes blind; on drives that lag."""

import math

import pytest

from shared.gait.table import MOVER_TABLE, MOVER_TROT
from shared.planner import command as c
from shared.planner import status as n
from shared.record import pack, unpack

from ..walker import Walker


class Lagging(Walker):
    """A walker whose joints follow the goals of the tick before behind the drives' lag, and give under no load."""

    def __init__(self, name="caramelo", rate_hz=50):
        super().__init__(name, rate_hz)
        self.sensed.valid.turned = 1
        unpack(self.params.sag_q16, (0, 0, 0))
        self.share, self.at = 1 / (1 + self.params.trot.lag_q8 / 256), None

    def tick(self):
        sent = list(self.planner.joints)
        flags = self.planner.tick(self.command, self.sensed)
        self.at = [a + self.share * (goal - a) for a, goal in zip(self.at or sent, sent, strict=True)]
        self.sensed.joints[:] = [round(a) for a in self.at]
        return flags


def walking(name="caramelo", speed=0.15, seconds=2.0, rate_hz=50):
    walker = Lagging(name, rate_hz)
    walker.walk("trot", speed)
    walker.ticks(round(seconds * rate_hz))
    assert walker.state == n.WALKING
    assert walker.planner.status.mover == MOVER_TROT
    return walker


@pytest.mark.parametrize("name", ["caramelo", "parallel", "long-leg", "unequal"])
@pytest.mark.parametrize("rate_hz", [50, 200])
def test_diagonals_swing_in_turn(name, rate_hz):
    walker, seen = walking(name, rate_hz=rate_hz), set()
    for _ in range(rate_hz):
        walker.tick()
        seen.add(walker.swinging())
    assert seen == {0, 0b1001, 0b0110}


def test_a_swing_lifts_a_foot_by_its_share_of_the_leg():
    walker, highest = walking(), -1.0
    for _ in range(50):
        walker.tick()
        highest = max(highest, max(foot[2] for foot in walker.feet_m()))
    assert highest == pytest.approx(-0.17 + 0.08 * 0.24, abs=0.002)


def test_it_goes_at_the_commanded_speed_by_its_own_odometry():
    walker = walking(speed=0.15, seconds=4.0)
    went = walker.planner.odometry.speed.x * walker.unit_m / 256 * 50
    assert went == pytest.approx(0.15, rel=0.01)


def test_stopped_it_stands_with_its_feet_at_rest():
    walker = walking()
    walker.mode(c.MODE_STAND)
    walker.until(n.STANDING, 5)
    assert walker.swinging() == 0
    rests = [[place * walker.unit_m for place in leg.rest] for leg in walker.params.legs]
    for foot, rest in zip(walker.feet_m(), rests, strict=True):
        assert foot[:2] == pytest.approx(rest[:2], abs=0.012)  # the centre of mass is 4 mm behind the hips' middle
        assert foot[2] == pytest.approx(-0.17, abs=0.003)


def test_a_gait_of_a_table_takes_over_once_it_stands():
    walker = walking()
    walker.gait("paper-trot")
    before = list(walker.planner.joints)
    for _ in range(8 * 50):
        walker.tick()
        step = max(abs(a - b) for a, b in zip(walker.planner.joints, before, strict=True))
        assert step <= max(pack(walker.params.joint_speed_max))
        before = list(walker.planner.joints)
    assert walker.planner.status.mover != MOVER_TROT
    assert walker.state == n.WALKING


def test_it_takes_over_from_a_gait_of_a_table():
    walker = Lagging()
    walker.walk("paper-trot", 0.05)
    walker.ticks(100)
    assert walker.planner.status.mover == MOVER_TABLE
    walker.gait("trot")
    walker.ticks(150)
    assert walker.planner.status.mover == MOVER_TROT
    assert walker.state == n.WALKING


@pytest.mark.parametrize("axis", [0, 1])
def test_fallen_it_sits_down(axis):
    walker = walking()
    for angle in range(0, 9000, 600):
        walker.sensed.tilt[axis] = angle
        walker.tick()
    walker.ticks(15)
    assert walker.planner.status.fallen
    assert walker.state == n.SITTING


@pytest.mark.parametrize("missing", ["joints", "tilt", "turned"])
def test_without_a_sense_it_goes_on_blind(missing):
    walker = walking()
    setattr(walker.sensed.valid, missing, 0)
    flags = walker.ticks(100)
    assert flags & n.BLIND
    assert walker.state == n.WALKING
    setattr(walker.sensed.valid, missing, 1)
    walker.ticks(20)
    assert walker.tick() & n.BLIND == 0


def test_the_fastest_command_is_its_own():
    walker = walking(speed=3.0, seconds=6.0)
    assert walker.planner.speed.vx == walker.params.trot.speed_max.vx


def test_a_pose_is_taken_standing():
    walker = Lagging()
    walker.stand()
    walker.gait("trot")
    walker.command.pose.z = round(0.02 / walker.unit_m)
    walker.ticks(200)
    assert [foot[2] for foot in walker.feet_m()] == pytest.approx([-0.19] * 4, abs=0.001)


@pytest.mark.parametrize(("told_m", "lifted_m"), [(0.03, 0.03), (0.5, 0.45 * 0.24)])
def test_a_swing_lifts_a_foot_as_high_as_it_is_told_within_what_a_step_takes(told_m, lifted_m):
    walker, highest = walking(), -1.0
    walker.command.height = round(told_m / walker.unit_m)
    for _ in range(75):
        walker.tick()
        highest = max(highest, max(foot[2] for foot in walker.feet_m()))
    assert highest == pytest.approx(-0.17 + lifted_m, abs=0.003)


@pytest.mark.parametrize("balance", [0, 1])
def test_it_levels_a_tilted_body_when_it_is_told_to(balance):
    walker = Lagging()
    walker.stand()
    walker.gait("trot")
    walker.command.balance = balance
    walker.sensed.tilt[1] = 300
    before = walker.feet_m()
    walker.ticks(20)
    moved = max(abs(a[2] - b[2]) for a, b in zip(before, walker.feet_m(), strict=True))
    assert (moved > 0.005) == bool(balance)


@pytest.mark.parametrize("known", [0, 1])
def test_without_levelling_a_commanded_roll_is_what_the_legs_make(known):
    walker = Lagging()
    walker.stand()
    walker.gait("trot")
    walker.command.balance, walker.sensed.valid.tilt = 1 - known, known
    walker.command.pose.roll = 910  # 5 deg
    walker.ticks(100)
    left, right = walker.feet_m()[1], walker.feet_m()[0]
    slope = (right[2] - left[2]) / (left[1] - right[1])
    assert slope == pytest.approx(math.tan(math.radians(5)), rel=0.1)
