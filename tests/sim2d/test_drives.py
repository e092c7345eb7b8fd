"""The model's numbers and the drives: datasheet points, saturation, speed, the coupled calf's virtual work."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim2d import terrain
from sim2d.actuator import CalfOnTorso, PositionServos
from sim2d.body import planar
from sim2d.model import Link, combine
from sim2d.run import simulate
from sim2d.world import World
from tests.float_twin.paper_trot import PaperTrot

from .conftest import CALF_SERVO, THIGH_SERVO, caramelo
from .helpers import Stand

eight = st.lists(st.floats(-3, 3), min_size=8, max_size=8)


def test_the_whole_robot_weighs_what_its_parts_do(robot):
    assert robot.mass_kg == pytest.approx(2.204)
    assert robot.torso_with_hips.mass_kg == pytest.approx(1.284 + 4 * 0.077)


def test_two_joined_points_have_the_moment_of_a_dumb_bell():
    end = Link(1.0, 1e-9, 0.0, 0.0)
    bell = combine([(end, -0.5, 0.0), (end, 0.5, 0.2)])
    assert (bell.mass_kg, bell.com_x_m, bell.com_z_m) == pytest.approx((2.0, 0.0, 0.1))
    assert bell.inertia_kgm2 == pytest.approx(2 * (0.5**2 + 0.1**2))


def test_payload_adds_its_mass_and_lifts_the_centre(robot):
    loaded = robot.loaded_torso(2.0)
    assert loaded.mass_kg == pytest.approx(robot.torso_with_hips.mass_kg + 2.0)
    assert loaded.com_z_m > robot.torso_with_hips.com_z_m
    with pytest.raises(ValueError, match="payload -1"):
        robot.loaded_torso(-1)


@pytest.mark.parametrize(("voltage_V", "stall_Nm", "rpm"), [(11.1, 2.3, 50), (12.0, 2.5, 55), (14.8, 3.1, 67)])
def test_voltage_points_are_the_datasheets(voltage_V, stall_Nm, rpm):
    """The damping of the table is rounded to three digits, so speeds agree within 0.1 %."""
    servo = THIGH_SERVO.at_voltage(voltage_V)
    assert servo.stall_torque_Nm == pytest.approx(stall_Nm)
    assert servo.stall_torque_Nm / servo.damping_Nms_rad == pytest.approx(rpm * math.tau / 60, rel=1e-3)
    assert servo.at_voltage(12.0).damping_Nms_rad == pytest.approx(THIGH_SERVO.damping_Nms_rad)


@pytest.mark.parametrize("voltage_V", [0.0, 9.0, 20.0, math.nan])
def test_a_voltage_outside_the_datasheet_is_refused(voltage_V):
    with pytest.raises(ValueError, match=r"supply voltage .* allowed 11\.1 \.\. 14\.8 V"):
        THIGH_SERVO.at_voltage(voltage_V)


def torques_of(drive, goal, position, speed):
    torque = [0.0] * 8
    drive.torques(goal, position, speed, 0.001, torque)
    return torque


@given(goal=eight, position=eight, speed=eight)
def test_a_servo_saturates_at_stall_and_loses_torque_with_speed(goal, position, speed):
    torque = torques_of(PositionServos([THIGH_SERVO, CALF_SERVO] * 4), goal, position, speed)
    for joint in range(8):
        servo = (THIGH_SERVO, CALF_SERVO)[joint % 2]
        drive = servo.stiffness_Nm_rad * (goal[joint] - position[joint])
        expected = max(-servo.stall_torque_Nm, min(servo.stall_torque_Nm, drive))
        assert torque[joint] == pytest.approx(expected - servo.damping_Nms_rad * speed[joint])


def test_a_servo_saturates_at_11_7_degrees():
    assert math.degrees(THIGH_SERVO.stall_torque_Nm / THIGH_SERVO.stiffness_Nm_rad) == pytest.approx(11.7, abs=0.05)


@given(goal=eight, position=eight, speed=eight)
def test_a_coupled_calf_gives_the_power_its_motors_give(goal, position, speed):
    motors = PositionServos([THIGH_SERVO, CALF_SERVO] * 4)
    joint = torques_of(CalfOnTorso(motors), goal, position, speed)

    def motor(values):
        return [v + (values[i - 1] if i % 2 else 0.0) for i, v in enumerate(values)]

    at_motors = torques_of(motors, motor(goal), motor(position), motor(speed))
    given_W = sum(t * w for t, w in zip(at_motors, motor(speed), strict=True))
    assert sum(t * w for t, w in zip(joint, speed, strict=True)) == pytest.approx(given_W, abs=1e-9)


def test_moving_the_thigh_motor_of_a_coupled_leg_alone_turns_the_calf_against_the_thigh():
    robot = caramelo(calf_on_torso=True)
    world = World(robot, terrain.flat())
    world.place(robot.stand_pose_rad, lift_m=0.3)
    world.pin_torso()
    goals = planar(robot.stand_pose_rad)
    goals[0], goals[1] = goals[0] + 0.2, goals[1] - 0.2
    world.advance(goals, 1500)
    thigh, calf = world.position_rad[0:2]
    assert thigh - robot.stand_pose_rad[1] == pytest.approx(0.2, abs=0.02)
    assert thigh + calf == pytest.approx(sum(robot.stand_pose_rad[1:3]), abs=0.02)


def test_a_coupled_robot_stands_and_walks():
    robot = caramelo(calf_on_torso=True)
    rec = simulate(robot, PaperTrot(robot), terrain.flat(), duration_s=6.0)
    assert rec.outcome.kind == "completed"
    assert rec.torso_x_m[-1] > 0.1


def test_end_stops_hold_a_leg_near_its_limit(robot):
    """A drive that always pushes with 2 N m gets 2 / 60 rad beyond."""

    class Push:
        def torques(self, goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm):
            torque_Nm[:] = [0.0, 2.0 - 0.1 * speed_rad_s[1]] + [0.0] * 6

    world = World(robot, terrain.flat(), actuator=Push())
    world.space.gravity = (0.0, 0.0)
    world.place(robot.stand_pose_rad, lift_m=0.3)
    world.pin_torso()
    world.advance([0.0] * 8, 3000)
    beyond = world.position_rad[1] - robot.calf_limits_rad[1]
    assert beyond == pytest.approx(2.0 / robot.end_stop_Nm_rad, abs=0.06 / robot.end_stop_Nm_rad + 1e-4)


def test_goals_beyond_the_limits_are_clamped_as_the_servo_would(robot):
    rec = simulate(robot, Stand((0.0, 9.0, -9.0) * 4), terrain.flat(), duration_s=0.1)
    assert set(rec.goal_rad[:, 1]) == {robot.thigh_limits_rad[1]}
    assert set(rec.goal_rad[:, 2]) == {robot.calf_limits_rad[0]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stand_pose_rad": (0.0,) * 11}, "11 angles, must be 12"),
        ({"calf_limits_rad": (1.0, -1.0)}, "must rise"),
        ({"thigh_length_m": 0.0}, "thigh_length_m = 0.0 must be above 0"),
        ({"end_stop_Nms_rad": -0.1}, "end_stop_Nms_rad = -0.1 must be 0 or more"),
    ],
)
def test_bad_robot_numbers_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        caramelo(**changes)


def test_bad_servo_numbers_are_refused():
    with pytest.raises(ValueError, match="damping_Nms_rad = 0"):
        replace(THIGH_SERVO, damping_Nms_rad=0)
    with pytest.raises(ValueError, match="must not be negative"):
        replace(THIGH_SERVO, coulomb_Nm=-0.1)
    with pytest.raises(ValueError, match="must both be above 0"):
        Link(0.0, 1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="7 servos, must be 8"):
        PositionServos([THIGH_SERVO] * 7)


def test_a_sub_step_too_long_for_the_servo_is_refused():
    light = caramelo(calf_servo=replace(CALF_SERVO, armature_kgm2=0.0))
    with pytest.raises(ValueError, match=r"dt_s = 0\.001 is too long for the calf servo"):
        World(light, terrain.flat())
    with pytest.raises(ValueError, match=r"dt_s = 0\.01"):
        World(caramelo(), terrain.flat(), dt_s=0.01)
