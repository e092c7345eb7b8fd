"""The same work in floats as functions of the core do, for comparing costs in one VM. Typical values, in SI.

``CASES`` names what is compared and how to get it ready: a function and its arguments. Lives in a
folder with ``probe`` (the robots as integer blocks) when it runs in a MicroPython.
"""

import math

from probe.robots import ATTITUDES, PARAMS

from shared.gait.gaits import GAITS, PAPER_TROT
from shared.gait.table import MOVER_TABLE

from . import body, fixed, leg, planner, reach, swing
from .attitude import of_block
from .balance import ERROR_MAX_RAD, Balance
from .gait import Gait
from .joint_current import CurrentLoop
from .pid import Pid

ROBOT = PARAMS[0]
UNIT_M = 2.0 ** -ROBOT.length_shift
RATE_HZ = ROBOT.rate_hz
GAINS = (0.3, 0.1, 0.01, 0.2, 0.3, RATE_HZ)
FOOT_M = (0.03, 0.06, -0.17)
JOINTS_RAD = (0.1, 0.6, -1.2)
POSE = (0.01, -0.01, 0.005, 0.1, -0.05, 0.07)


class Bag:
    """Named values."""


def rad(angle_brad):
    """Return an angle in rad."""
    return angle_brad * 2 * math.pi / 65536


def one_leg(number):
    """Return what the float leg needs of a leg's block."""
    base = ROBOT.legs[number]
    one = Bag()
    one.side_l1, one.l2, one.l3 = [at * UNIT_M for at in (base.hip_length, base.thigh_length, base.calf_length)]
    one.l1 = abs(one.side_l1)
    one.knee = base.knee
    one.hip = [base.hip[axis] * UNIT_M for axis in range(3)]
    one.rest = [base.rest[axis] * UNIT_M for axis in range(3)]
    one.low = [rad(base.lowest[joint]) for joint in range(3)]
    one.high = [rad(base.highest[joint]) for joint in range(3)]
    return one


def whole_robot():
    """Return what the float planner needs of a robot's block."""
    units = (UNIT_M / 256, UNIT_M / 256, 2.0**-18)
    robot = Bag()
    robot.unit_m, robot.speed_unit, robot.legs = UNIT_M, units, [one_leg(number) for number in range(4)]
    robot.speed_max = [ROBOT.speed_max[axis] * units[axis] for axis in range(3)]
    robot.speed_slew = [ROBOT.speed_slew[axis] * units[axis] for axis in range(3)]
    scale = [UNIT_M] * 3 + [rad(1)] * 3
    robot.pose_max = [ROBOT.pose_max[axis] * scale[axis] for axis in range(6)]
    robot.pose_slew = [ROBOT.pose_slew[axis] * scale[axis] for axis in range(6)]
    robot.joint_step, robot.sit_z = rad(ROBOT.joint_step), ROBOT.sit_z * UNIT_M
    robot.joint_top, robot.coupled = [rad(ROBOT.joint_top[joint]) for joint in range(3)], ROBOT.coupled
    robot.stride, robot.gains = ROBOT.stride_max * UNIT_M, GAINS
    return robot


def walking(gait):
    """Return the tick of a float planner that walks, with a command and senses as the core's walk has."""
    robot = planner.Planner(whole_robot(), [Gait(table or PAPER_TROT, RATE_HZ) for _, _, table in GAITS])
    command, sensed = Bag(), Bag()
    command.mode, command.gait, command.balance, command.height_m = planner.WALK, gait, 1, 0.0
    command.speed, command.pose = [v / 2 for v in robot.robot.speed_max], [0.0] * 6
    sensed.roll, sensed.pitch, sensed.attitude_ok = 0.01, -0.02, 1
    sensed.joints, sensed.joints_ok = [0.0] * 12, 1
    for _ in range(300):
        robot.tick(command, sensed)
    return robot.tick, (command, sensed)


def filtering():
    """Return the step of a float attitude filter that has been aligned."""
    block = ATTITUDES[0]
    attitude = of_block(block)
    accel = (500, -300, block.one_g)
    for _ in range(block.align_ticks):
        attitude.step((5, 6, 7), accel)
    return lambda gyro: (attitude.step(gyro, accel), attitude.angles()), ((300, -200, 100),)


def current_loop():
    """Return the step of a float current loop."""
    loop = CurrentLoop(0.2, 0.01, 24.0, 7, 0.3)
    loop.q_ref = 1.0
    return loop.step, (1.2, 0.5, -0.2, -0.3)


def _leg_case(function, first):
    one = one_leg(0)
    if function is leg.inverse:
        return function, (first, one.side_l1, one.l2, one.l3, one.knee)
    return function, (first, one.side_l1, one.l2, one.l3)


def _reach_case():
    one = one_leg(0)
    return reach.clamp, (FOOT_M, one.l1, one.l2, one.l3)


CASES = [
    ("fixed.sin_q15", lambda: (fixed.sine, (12345,))),
    ("fixed.cos_q15", lambda: (fixed.cosine, (12345,))),
    ("fixed.atan2_brad", lambda: (fixed.angle_deg, (12345, -6789))),
    ("fixed.isqrt", lambda: (math.sqrt, (123456789,))),
    ("fixed.hypot", lambda: (fixed.length, (12345, -6789))),
    ("leg.leg_forward", lambda: _leg_case(leg.forward, JOINTS_RAD)),
    ("leg.leg_inverse", lambda: _leg_case(leg.inverse, FOOT_M)),
    ("reach.reach_foot:near", _reach_case),
    ("body.body_rotation", lambda: (body.rotation, (POSE,))),
    ("swing.cycloid_q15", lambda: (swing.advance, (0.3,))),
    ("swing.lift_q15", lambda: (swing.lift, (0.3,))),
    ("pid.pid_step", lambda: (Pid(*GAINS).step, (0.1, 0.05, ERROR_MAX_RAD))),
    ("balance.balance_step", lambda: (Balance(GAINS).step, ((0.1, 0.05), (0.02, 0.01)))),
    ("attitude.attitude_step", filtering),
    ("joint_current.current_step", current_loop),
]
for _at, (_name, _mover, _) in enumerate(GAITS):
    if _mover == MOVER_TABLE:  # the float planner knows no other
        CASES.append(("planner.tick:" + _name, lambda gait=_at: walking(gait)))
