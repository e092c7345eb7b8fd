"""Figures of a recording, against recordings whose figures are known, and the paper's own walk."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim2d import metrics, terrain
from sim2d.run import simulate
from tests.float_twin.paper_trot import Balance, PaperTrot

from .conftest import caramelo
from .helpers import Stand, foot_skate_m


@pytest.fixture(scope="module")
def standing():
    robot = caramelo()
    return simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=2.0)


@pytest.fixture(scope="module")
def walk():
    robot = caramelo()
    return simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=120.0, distance_m=1.5)


def walked(ground, start_x_m=0.0, **planner):
    robot = caramelo()
    distance_m = ground.finish_x_m - start_x_m
    return simulate(
        robot, PaperTrot(robot, **planner), ground, duration_s=150.0, distance_m=distance_m, start_x_m=start_x_m
    )


def test_a_robot_that_stands_goes_nowhere_and_swings_nothing(standing):
    assert abs(metrics.mean_speed_m_s(standing)) < 1e-5
    assert metrics.pitch_range_deg(standing) < 0.01
    assert metrics.swing_clearances_m(standing) == []
    assert metrics.min_clearance_m(standing) == 0.0
    assert foot_skate_m(standing, 1.0) < 1e-5


def test_speed_and_pitch_range_of_a_made_up_walk(standing):
    n = len(standing.time_s)
    made = replace(
        standing,
        torso_x_m=np.linspace(0.2, 0.3, n),
        torso_pitch_rad=np.radians(np.where(np.arange(n) % 2, 2.0, -1.0)),
    )
    assert metrics.mean_speed_m_s(made) == pytest.approx(0.1 / 2.0)
    assert metrics.pitch_range_deg(made) == pytest.approx(3.0)


def test_clearance_counts_above_the_highest_ground_the_foot_passes(standing):
    n = len(standing.time_s)
    x, z = np.full(n, 0.115), np.full(n, 0.012)
    x[10:31], z[11:30] = np.linspace(0.3, 0.4, 21), 0.012 + 0.05 * np.sin(np.linspace(0.1, math.pi - 0.1, 19))
    x[:10], x[31:] = 0.3, 0.4
    contact, feet = standing.contact.copy(), standing.foot_xz_m.copy()
    contact[11:30, 2] = False
    feet[:, 2, 0], feet[:, 2, 1] = x, z
    made = replace(standing, contact=contact, foot_xz_m=feet, terrain=terrain.box(0.03, 0.34, 0.03))
    assert metrics.swings(made, 2) == [(11, 30)]
    assert metrics.swing_clearances_m(made) == [pytest.approx(0.05 - 0.03, abs=1e-6)]


def test_torque_share_is_of_the_stall_torque_at_the_supply_voltage(standing):
    made = replace(standing, torque_Nm=np.tile([0.0, 1.25, -2.23], (len(standing.time_s), 4)))
    assert metrics.torque_rms_fraction(made) == pytest.approx([0.0, 0.5, 1.0] * 4)


def test_a_dragged_foot_skates_and_a_rolling_one_does_not(standing):
    n = len(standing.time_s)
    path = np.linspace(0.0, 0.1, n)
    feet, joints = standing.foot_xz_m.copy(), np.tile(standing.joint_rad[-1], (n, 1))
    feet[:, :, 1] = standing.foot_radius_m
    feet[:, :, 0] = feet[0, :, 0]
    feet[:, 0, 0] += path
    still = replace(standing, foot_xz_m=feet, joint_rad=joints, torso_pitch_rad=np.zeros(n))
    assert foot_skate_m(still, 2.0) == pytest.approx(0.1)
    joints = joints.copy()
    joints[:, 2] += path / standing.foot_radius_m
    assert foot_skate_m(replace(still, joint_rad=joints), 2.0) == pytest.approx(0.0, abs=1e-9)


def test_the_papers_walk_on_flat_ground(walk):
    """Asked for 0.05 m/s: knees that all bend one way push the sagging body back at every load transfer."""
    assert walk.outcome.kind == "arrived"
    assert 0.55 * 0.05 <= metrics.mean_speed_m_s(walk) <= 0.90 * 0.05
    assert 0.036 < metrics.mean_speed_m_s(walk) < 0.040
    assert 1.5 < metrics.pitch_range_deg(walk, skip_s=2.0) < 5.0
    assert 0.020 < metrics.min_clearance_m(walk) < 0.036
    assert len(metrics.swing_clearances_m(walk)) == pytest.approx(2 * 19.7 * 2, abs=6)


def test_evenly_spaced_points_clear_38_mm_of_50_and_walk_faster(walk):
    robot = caramelo()
    even = simulate(robot, PaperTrot(robot, p_t=1), terrain.flat(), duration_s=120.0, distance_m=1.5)
    assert np.median(metrics.swing_clearances_m(even)) == pytest.approx(0.038, abs=0.002)
    assert metrics.mean_speed_m_s(even) > metrics.mean_speed_m_s(walk)


def test_it_walks_backwards_at_each_load_transfer(walk):
    """The body advances only while all four feet stand; in the swing phases it loses about a third of that again."""
    x = walk.torso_x_m
    cycle = np.arange(400, 500)
    gained = np.diff(x[cycle]).clip(min=0).sum()
    lost = -np.diff(x[cycle]).clip(max=0).sum()
    assert 0.2 < lost / gained < 0.5


def test_the_result_does_not_hang_on_the_sub_step():
    """Over whole cycles: arrival at a line may fall on the one or the other of two steps."""
    robot = caramelo()
    fine, usual = (
        simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=40.0, dt_s=dt_s) for dt_s in (0.0005, 0.001)
    )
    assert metrics.mean_speed_m_s(fine) == pytest.approx(metrics.mean_speed_m_s(usual), rel=0.01)


@pytest.mark.parametrize("start_x_m", [0.0, -0.02, -0.04, -0.06, -0.08])
def test_the_papers_walk_passes_2_cm_and_fails_5_cm_from_every_start(start_x_m):
    assert walked(terrain.step(0.02), start_x_m).outcome.kind == "arrived"
    assert walked(terrain.step(0.05), start_x_m).outcome.kind in ("stuck", "fell")


def test_the_papers_walk_passes_the_ramp_up_and_down():
    assert walked(terrain.ramp(5.34)).outcome.kind == "arrived"


@pytest.mark.parametrize("seed", [1, 2])
def test_balance_steadies_the_pitch_on_stones(seed):
    ground = terrain.stones(seed, length_m=1.0)
    without, balanced = walked(ground), walked(ground, balance=Balance())
    assert without.outcome.ok
    assert balanced.outcome.ok
    assert metrics.pitch_range_deg(balanced, 2.0) < 0.8 * metrics.pitch_range_deg(without, 2.0)


def test_two_kilograms_cost_speed_and_knee_torque(walk):
    robot = caramelo()
    loaded = simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=40.0, payload_kg=2.0)
    assert metrics.mean_speed_m_s(loaded) < 0.85 * metrics.mean_speed_m_s(walk)
    knees = slice(2, 12, 3)
    assert metrics.torque_rms_fraction(loaded)[knees].mean() > 1.7 * metrics.torque_rms_fraction(walk)[knees].mean()


def test_a_weaker_supply_is_slower(walk):
    robot = caramelo()
    weak = simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=40.0, supply_voltage_V=11.1)
    assert metrics.mean_speed_m_s(weak) < metrics.mean_speed_m_s(walk)
    assert weak.stall_Nm[1] == pytest.approx(2.3)
