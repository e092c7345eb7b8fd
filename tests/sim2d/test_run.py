"""A run: how it starts, what the controller senses, when goals act, how it ends."""

import itertools
import math
import struct
from dataclasses import replace

import numpy as np
import pytest

from sim2d import metrics, terrain
from sim2d.body import planar
from sim2d.model import SensorModel
from sim2d.referee import Referee
from sim2d.run import LateBus, simulate
from sim2d.world import World, _count_bodies
from tests.float_twin.paper_trot import PaperTrot

from .conftest import caramelo
from .helpers import Stand


def test_it_starts_on_the_ground_at_the_offset_asked(robot):
    rec = simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=0.1, start_x_m=0.07, settle_s=0.0)
    assert rec.torso_x_m[0] == pytest.approx(0.07, abs=1e-9)
    assert rec.foot_xz_m[0, :, 1] == pytest.approx([robot.foot_radius_m] * 4, abs=1e-9)
    assert rec.torso_z_m[0] == pytest.approx(0.170 + robot.foot_radius_m, abs=1e-6)
    assert rec.joint_rad[0] == pytest.approx(robot.stand_pose_rad)


def test_it_starts_on_top_of_whatever_is_under_its_feet(robot):
    ground = terrain.step(0.05, start_m=0.2, length_m=1.0)
    world = World(robot, ground)
    world.place(robot.stand_pose_rad, x_m=0.7)
    foot = world.parts.bodies[2].local_to_world(world.parts.calf_foot_m)
    assert foot.y == pytest.approx(0.05 + robot.foot_radius_m)


def test_a_standing_robot_senses_gravity_its_pose_and_half_its_weight_on_either_side(robot):
    stand = Stand(robot.stand_pose_rad)
    rec = simulate(robot, stand, terrain.flat(), duration_s=1.0)
    last = stand.sensed[-1]
    assert math.hypot(*last.specific_force_m_s2) == pytest.approx(9.81, abs=1e-6)
    assert last.specific_force_m_s2[0] == pytest.approx(-9.81 * math.sin(last.pitch_rad), abs=1e-6)
    assert last.joint_position_rad == pytest.approx(rec.joint_rad[-1], abs=1e-4)
    assert (last.time_s, last.roll_rad) == (pytest.approx(0.98), 0.0)
    assert rec.foot_force_N[-1, :, 1].sum() == pytest.approx(robot.mass_kg * 9.81, rel=1e-3)
    assert np.all(rec.contact[-1])


def test_signs_nose_down_is_positive_and_so_is_falling_forward(robot):
    """Front legs folded: the robot pitches nose down, so gravity's reaction has a part along -x of the body."""
    folded = (0.0, 1.2, -2.15) * 2 + tuple(robot.stand_pose_rad[6:])
    stand = Stand(folded)
    simulate(robot, stand, terrain.flat(), duration_s=1.5)
    assert stand.sensed[-1].pitch_rad > 0.05
    assert stand.sensed[-1].specific_force_m_s2[0] < -0.4
    assert max(s.pitch_rate_rad_s for s in stand.sensed) > 0.1


def test_encoders_round_and_noise_is_seeded(robot):
    sensors = SensorModel(4096, 0.01)
    noisy = replace(robot, sensors=sensors)

    def sensed(seed):
        stand = Stand(robot.stand_pose_rad)
        simulate(noisy, stand, terrain.flat(), duration_s=0.5, seed=seed)
        return stand.sensed

    first = sensed(1)
    counts = np.array(first[-1].joint_position_rad) * 4096 / math.tau
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert [s.pitch_rad for s in first] == [s.pitch_rad for s in sensed(1)]
    assert [s.pitch_rad for s in first] != [s.pitch_rad for s in sensed(2)]
    assert np.std([s.pitch_rad for s in first]) == pytest.approx(0.01, rel=0.6)


@pytest.mark.parametrize("delay_s", [0.0, 0.02, 0.035])
def test_a_goal_acts_exactly_the_bus_delay_later(robot, delay_s):
    """A goal sent every 20 ms of 1 ms sub-steps: the drive must see each from its own arrival on."""
    seen = []

    class Spy:
        def torques(self, goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm):
            seen.append(goal_rad[0])
            torque_Nm[:] = [0.0] * 8

    world = World(robot, terrain.flat(), actuator=Spy())
    world.place(robot.stand_pose_rad, lift_m=1.0)
    bus = LateBus(world, delay_s, [-1.0] * 8)
    for tick in range(6):
        bus.send([float(tick)] * 8)
        bus.advance_to((tick + 1) * 20)
    late = round(delay_s / 0.001)
    assert seen == [(-1.0 if step < late else (step - late) // 20) for step in range(120)]


@pytest.mark.parametrize("rate_hz", [20, 60, 333, 500])
def test_ticks_come_at_the_controllers_rate_for_any_rate(robot, rate_hz):
    stand = Stand(robot.stand_pose_rad)
    stand.rate_hz = rate_hz
    rec = simulate(robot, stand, terrain.flat(), duration_s=1.0, settle_s=0.0)
    assert len(rec.time_s) == rate_hz + 1
    assert np.abs(rec.time_s - np.arange(rate_hz + 1) / rate_hz).max() <= 0.001


def test_arriving_ends_the_run_and_progress_reaches_one(robot):
    shares = []
    rec = simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=30, distance_m=0.1, progress=shares.append)
    assert rec.outcome.kind == "arrived"
    assert rec.outcome.ok
    assert rec.outcome.sentence.startswith("arrived after ")
    assert metrics.distance_m(rec) >= 0.1
    assert f"{metrics.distance_m(rec):.3f} m on" in rec.outcome.sentence
    assert shares[-1] == 1.0
    assert shares == sorted(shares)


def test_not_arriving_in_time_is_a_timeout(robot):
    rec = simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=3, distance_m=1.0)
    assert rec.outcome.kind == "timeout"
    assert not rec.outcome.ok
    assert "of 1.000 m" in rec.outcome.sentence


def test_standing_still_with_somewhere_to_go_is_being_stuck(robot):
    rec = simulate(
        robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=60, distance_m=1.0, stuck_after_s=2.0
    )
    assert rec.outcome.kind == "stuck"
    assert rec.time_s[-1] == pytest.approx(2.0)


def test_a_robot_that_sits_down_has_its_torso_on_the_ground(robot):
    low = caramelo(torso_half_height_m=0.12)
    rec = simulate(low, Stand((0.0, 1.3, -2.19) * 4), terrain.flat(), duration_s=5)
    assert rec.outcome.kind == "fell"
    assert "the torso touched the ground" in rec.outcome.sentence


def test_a_drive_that_blows_the_numbers_up_is_an_error_not_a_result(robot):
    class Runaway:
        def torques(self, goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm):
            torque_Nm[:] = [-1e6 * w + 1.0 for w in speed_rad_s]

    with pytest.raises(ArithmeticError, match="too strong for the sub-step"):
        simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=5, actuator=Runaway())


@pytest.mark.parametrize(("tilt_deg", "kind"), [(59, None), (61, "fell")])
def test_a_tilt_beyond_60_degrees_is_a_fall(tilt_deg, kind):
    outcome = Referee(0.0, None, 10.0, 5.0).judge(1.0, 0.0, math.radians(tilt_deg), False)
    assert (outcome.kind if outcome else None) == kind


def test_without_a_voltage_the_servos_get_their_nominal_one(robot):
    rec = simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=0.1)
    assert rec.stall_Nm == pytest.approx([0.0, 2.5, 2.23] * 4)


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ((0.0,) * 4 + (math.nan,) + (0.0,) * 7, "joint 4 is nan"),
        ((0.0,) * 4 + (math.inf,) + (0.0,) * 7, "joint 4 is inf"),
        ((0.0,) * 3, "3 angles, must be 12"),
    ],
)
def test_a_goal_that_is_no_angle_never_reaches_a_drive(robot, pose, message):
    with pytest.raises(ValueError, match=rf"goal at 0\.000 s: {message}"):
        simulate(robot, Stand(pose), terrain.flat(), duration_s=1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration_s": 0}, "duration 0 s"),
        ({"duration_s": math.nan}, "duration nan s"),
        ({"duration_s": 1, "distance_m": -1}, "distance -1 m"),
        ({"duration_s": 1, "bus_delay_s": -0.1}, "bus_delay_s"),
        ({"duration_s": 1, "settle_s": -1}, "settle_s"),
        ({"duration_s": 1, "start_x_m": -9}, "start_x_m"),
        ({"duration_s": 1, "supply_voltage_V": 5}, "supply voltage 5 V"),
        ({"duration_s": 1, "payload_kg": -2}, "payload -2 kg"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(robot, arguments, message):
    with pytest.raises(ValueError, match=message) as caught:
        simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), **arguments)
    assert "\n" not in str(caught.value)


def test_a_controller_rate_beyond_one_tick_per_sub_step_is_refused(robot):
    stand = Stand(robot.stand_pose_rad)
    stand.rate_hz = 1001
    with pytest.raises(ValueError, match=r"rate 1001 Hz: allowed 1 \.\. 1000"):
        simulate(robot, stand, terrain.flat(), duration_s=1)


def test_loose_stones_are_recorded_as_they_move(robot):
    ground = terrain.gravel(1, start_m=0.2, length_m=0.1)
    rec = simulate(robot, PaperTrot(robot), ground, duration_s=8.0)
    assert rec.stone_xz_m.shape == (len(rec.time_s), len(ground.loose), 2)
    assert rec.stone_turn_rad.shape == rec.stone_xz_m.shape[:2]
    assert np.ptp(rec.stone_xz_m[:, :, 0], axis=0).max() > 0.001
    assert rec.stone_xz_m[:, :, 1].min() > 0.0


def test_bodies_visited_in_another_order_are_noticed(robot):
    world = World(robot, terrain.flat())
    assert _count_bodies(world.space, world.parts.bodies) >= 9
    with pytest.raises(RuntimeError, match="another order"):
        _count_bodies(world.space, world.parts.bodies[::-1])


class Listed:
    """Contacts of a foot as pymunk.batch lists them: whose, how many points, and how hard and where it is pushed."""

    def __init__(self, foot, place, pushes):
        self.ints = struct.pack(f"{3 * len(pushes)}P", *[number for _ in pushes for number in (foot, 0, 1)])
        self.floats = struct.pack(f"{5 * len(pushes)}d", *[part for push in pushes for part in (*push, *place, 0.0)])

    def clear(self):
        """Keep what is there."""

    def int_buf(self):
        return self.ints

    def float_buf(self):
        return self.floats


def test_in_whatever_order_contacts_are_listed_the_force_is_the_same(robot, monkeypatch):
    """They are listed by where they lie in memory; three pushes summed one by one differed in the last bit."""
    world = World(robot, terrain.flat())
    world.place(robot.stand_pose_rad)
    calf = world.parts.bodies[2]
    monkeypatch.setattr("sim2d.world.batch.get_space_arbiters", lambda *_: None)
    forces = set()
    for pushes in itertools.permutations([(0.57, 0.7), (0.69, 0.26), (0.59, 0.35)]):
        world._touch = Listed(calf.id, calf.local_to_world(world.parts.calf_foot_m), pushes)
        contacts = world.contacts()
        assert contacts.foot_touches == (True, False, False, False)
        forces.add(contacts.foot_force_N)
    assert len(forces) == 1
    assert forces.pop()[0] == pytest.approx((1850, 1310))


@pytest.mark.parametrize("link_radius_m", [0.006, 1e-5])
def test_a_calf_lies_on_an_edge_under_it(link_radius_m):
    """A thin post stands between the front feet and knees; the crouch asked for would go through it."""
    post_x_m, post_m = 0.072, 0.040
    corners = ((-5.0, 0.0), (0.070, 0.0), (0.070, post_m), (0.074, post_m), (0.074, 0.0), (5.0, 0.0))
    robot = caramelo(link_radius_m=link_radius_m)
    world = World(robot, terrain.Terrain("post", corners))
    world.place(robot.stand_pose_rad)
    assert front_calves_m(world, post_x_m).min() > post_m
    world.advance(planar((0.0, 0.9, -2.19) * 4), 3000)
    assert front_calves_m(world, post_x_m) == pytest.approx(post_m, abs=0.015)
    assert front_calves_m(world, post_x_m).min() > post_m - 1e-3


def front_calves_m(world, x_m):
    """Height of the front calves' lines where they pass ``x_m``."""
    heights = []
    for leg in (0, 1):
        knee = world.parts.bodies[1 + 2 * leg].local_to_world(world.parts.thigh_knee_m)
        foot = world.parts.bodies[2 + 2 * leg].local_to_world(world.parts.calf_foot_m)
        heights.append(knee.y + (foot.y - knee.y) * (x_m - knee.x) / (foot.x - knee.x))
    return np.array(heights)
