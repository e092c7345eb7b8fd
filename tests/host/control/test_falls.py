"""Robots that are thrown over in space: limp within 0.1 s; up again from the belly, else a true sentence."""

import math
import random

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")

from host.control.safety import FALLEN_RAD
from host.robot.file import load_robot
from host.sim.space.plant import SpacePlant

from .rig import AHEAD, RESET, REST, STAND, STILL, STOP, Rig

PUSHED_S, LIMP_S = 0.12, 0.1


class Thrown:
    """A robot that walks, is pushed by a change of velocity to one side, and falls; it lies there after 5 s."""

    def __init__(self, name, way_deg, change_m_s):
        self.plant = SpacePlant(load_robot(name))
        self.rig = Rig(name, self.plant)
        self.rig.run(0.2)
        self.rig.run(5.0, STILL, first=STAND)
        self.rig.run(1.3, AHEAD)
        self.over_s = self.limp_s = None
        force_N = change_m_s * self.rig.robot.mass_kg / PUSHED_S
        self.force_N = force_N * math.cos(math.radians(way_deg)), force_N * math.sin(math.radians(way_deg))
        self.began_s = self.rig.now_s
        self.rig.each = self.look
        self.rig.run(5.0, AHEAD)
        self.rig.each = lambda: None

    def look(self):
        """Push, and keep when it was tilted too far, and when its joints were let go."""
        time_s = self.rig.now_s - self.began_s
        self.plant.world.push(self.force_N if time_s < PUSHED_S else (0.0, 0.0))
        if self.over_s is None and max(map(abs, self.plant.world.attitude_rad()[:2])) > FALLEN_RAD:
            self.over_s = time_s
        if self.limp_s is None and not self.rig.holding:
            self.limp_s = time_s


BELLY = 0.0, 1.5  # of those that were tried for Parallel, a push after which it lies on its belly
FALLS = [(name, way_deg, 2.0) for name in ("caramelo", "parallel") for way_deg in (90, -90)]
FALLS += [("caramelo", 40, 2.0), ("parallel", 40, 3.0), ("caramelo", 130, 3.0), ("parallel", -130, 3.0)]
FALLS.append(("caramelo", 0, 3.0))


@pytest.mark.parametrize(("name", "way_deg", "change_m_s"), FALLS)
def test_fallen_it_is_limp_within_a_tenth_of_a_second(name, way_deg, change_m_s):
    """Requirement. It turns faster than its gyroscope can tell; measured up to 0.08 s."""
    robot = Thrown(name, way_deg, change_m_s)
    assert robot.over_s is not None
    assert robot.limp_s is not None
    assert robot.limp_s - robot.over_s <= LIMP_S
    assert robot.rig.supervisor.state == "fault"


class Lying:
    """A robot that was dropped, its legs anywhere within their limits, and lies there, its joints off."""

    def __init__(self, name, seed):
        robot, dice = load_robot(name), random.Random(seed)
        self.plant = SpacePlant(robot)
        self.rig, self.world = Rig(name, self.plant), self.plant.world
        self.limits_rad = np.array([robot.joint_limits_rad(leg)[joint] for leg in range(4) for joint in range(3)])
        data, hip = self.world.data, int(self.world.joints.q[0])
        data.qpos[hip - 7 : hip] = 0.0, 0.0, 1.5 * robot.stance.rest_height_m, 1.0, 0.0, 0.0, 0.0  # place, quaternion
        data.qpos[self.world.joints.q] = [dice.uniform(*limits) for limits in self.limits_rad]
        self.rig.run(4.0)
        self.beyond_rad = max(0.0, self.beyond(self.world.true_joints_rad()))  # a limp leg leans on its stops
        self.most_Nm = 0.0
        self.rig.each = self.look

    def beyond(self, angles_rad):
        return float(np.max([self.limits_rad[:, 0] - angles_rad, angles_rad - self.limits_rad[:, 1]]))

    def look(self):
        """Check goals while it gets up, and keep the most that a drive gave of its stall torque."""
        supervisor = self.rig.supervisor
        if supervisor.armed and supervisor.driver.state != "standing":
            assert self.beyond(np.array(supervisor.goals)) <= self.beyond_rad + 0.002
            force_Nm = np.abs(self.world.data.actuator_force / self.world.stall_Nm)
            self.most_Nm = max(self.most_Nm, float(force_Nm.max()))

    def stands_after_s(self):
        """Tell it to stand; return after how long it does."""
        began_s = self.rig.now_s
        self.rig.send(STAND)
        while self.rig.now_s - began_s < 15.0:
            self.rig.run(0.2, STILL)
            if self.rig.supervisor.state == "standing":
                return self.rig.now_s - began_s
        raise AssertionError(f"{self.rig.supervisor.state}: {self.rig.reason}")


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(more, marks=pytest.mark.slow) for more in range(3, 20))])
@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_from_its_belly_it_gets_up(request, name, seed):
    """Its legs anywhere: it folds them, sits, stands; within the torque of standing up and the joints' limits."""
    if (name, seed) == ("caramelo", 10):
        why = "it lies on its own legs, rolled by 44 deg, and falls over as it rises"
        request.applymarker(pytest.mark.xfail(strict=True, reason=why))
    robot = Lying(name, seed)
    assert not robot.rig.holding
    assert robot.stands_after_s() < 12.0
    assert robot.most_Nm <= robot.rig.robot.stand.torque_fraction + 0.01
    robot.rig.run(1.0, STILL)
    assert max(map(abs, robot.world.attitude_rad()[:2])) < math.radians(5)
    robot.rig.run(2.0, AHEAD)
    assert robot.rig.supervisor.state == "walking"


def test_nothing_moves_before_it_is_told_and_a_stop_acts_in_it():
    robot = Lying("caramelo", 1)
    assert robot.rig.supervisor.stretched()
    assert robot.rig.reason == "the joints are off: stand up first"
    robot.rig.run(1.0, STILL, first=STAND)
    assert robot.rig.supervisor.driver.state == "folding"
    assert robot.rig.reason == "it lies on its belly and folds its legs"
    robot.rig.send(STOP)
    assert not robot.rig.holding
    robot.rig.run(1.0, STILL)
    assert not robot.rig.holding
    robot.rig.run(0.5, STILL, first=RESET)
    assert not robot.rig.holding
    assert robot.rig.put_back == 0
    assert robot.stands_after_s() < 12.0


def test_told_to_let_go_while_it_gets_up_it_sits_and_lets_go():
    robot = Lying("caramelo", 1)
    robot.rig.run(1.0, STILL, first=STAND)
    robot.rig.run(8.0, first=REST)
    assert (robot.rig.supervisor.state, robot.rig.holding) == ("disarmed", False)


@pytest.mark.parametrize(("roll_deg", "pitch_deg", "where"), [
    (90, 0, "right side"), (-90, 0, "left side"), (0, 90, "nose"), (0, -90, "tail"), (0, 180, "back"),
])  # fmt: skip
def test_from_elsewhere_a_true_sentence(roll_deg, pitch_deg, where, monkeypatch):
    """It says how it lies, stays a fault however often it is reset, and arms nothing."""
    rig = Rig()
    rig.stand()
    attitude = math.radians(roll_deg), math.radians(pitch_deg)
    monkeypatch.setattr(rig.supervisor, "_read_attitude", lambda: attitude)
    monkeypatch.setattr(rig.supervisor, "_put_back", lambda: None)  # a real robot
    rig.run(0.1)
    told = f"the robot has fallen over onto its {where}: put it on its feet, because it can't turn over by itself"
    for message in (STILL, RESET, STAND, RESET, STAND):
        rig.run(0.1, first=message)
        assert (rig.supervisor.state, rig.holding, rig.reason) == ("fault", False, f"{told}; then reset")


def test_thrown_onto_its_belly_it_is_reset_and_gets_up():
    """The whole story; in the simulator a reset puts one that lies on its back on its feet, and this one not."""
    robot = Thrown("parallel", *BELLY)
    rig = robot.rig
    assert max(map(abs, robot.plant.world.attitude_rad()[:2])) < FALLEN_RAD
    assert rig.reason == (
        "the robot has fallen and lies on its belly: it can get up by itself; keep clear of its legs; then reset")
    rig.run(1.0, STILL, first=STAND)
    assert not rig.holding
    rig.run(1.0, STILL, first=RESET)
    assert (rig.supervisor.state, rig.holding, rig.put_back) == ("disarmed", False, 0)
    rig.run(12.0, STILL, first=STAND)
    assert (rig.supervisor.state, rig.reason) == ("standing", "the sticks are at rest")
