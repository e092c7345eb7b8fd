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
from .si import Plain, planner_si

PLANNER, RATE_HZ = planner_si(PARAMS[0]), PARAMS[0].rate_hz
ONE, GAINS = PLANNER.legs[0], PLANNER.gains
LINKS = (ONE.side_l1, ONE.l2, ONE.l3)
FOOT_M = (0.03, 0.06, -0.17)
JOINTS_RAD = (0.1, 0.6, -1.2)
POSE = (0.01, -0.01, 0.005, 0.1, -0.05, 0.07)


def walking(gait):
    """Return the tick of a float planner that walks, with a command and senses as the core's walk has."""
    robot = planner.Planner(PLANNER, [Gait(table or PAPER_TROT, RATE_HZ) for _, _, table in GAITS])
    speed = [v / 2 for v in PLANNER.speed_max]
    command = Plain(mode=planner.WALK, gait=gait, balance=1, height_m=0.0, speed=speed, pose=[0.0] * 6)
    sensed = Plain(roll=0.01, pitch=-0.02, attitude_ok=1, joints=[0.0] * 12, joints_ok=1)
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


CASES = [
    ("fixed.sin_q15", lambda: (fixed.sine, (12345,))),
    ("fixed.cos_q15", lambda: (fixed.cosine, (12345,))),
    ("fixed.atan2_brad", lambda: (fixed.angle_deg, (12345, -6789))),
    ("fixed.isqrt", lambda: (math.sqrt, (123456789,))),
    ("fixed.hypot", lambda: (fixed.length, (12345, -6789))),
    ("leg.leg_forward", lambda: (leg.forward, (JOINTS_RAD,) + LINKS)),
    ("leg.leg_inverse", lambda: (leg.inverse, (FOOT_M,) + LINKS + (ONE.knee,))),
    ("reach.reach_foot:near", lambda: (reach.clamp, (FOOT_M, ONE.l1, ONE.l2, ONE.l3))),
    ("body.body_rotation", lambda: (body.rotation, (POSE,))),
    ("swing.cycloid_q15", lambda: (swing.advance, (0.3,))),
    ("swing.lift_q15", lambda: (swing.lift, (0.3,))),
    ("pid.pid_step", lambda: (Pid(*GAINS).step, (0.1, 0.05, ERROR_MAX_RAD))),
    ("balance.balance_step", lambda: (Balance(GAINS).step, ((0.1, 0.05), (0.02, 0.01)))),
    ("attitude.attitude_step", filtering),
    ("joint.current_step", current_loop),
]
for _at, (_name, _mover, _) in enumerate(GAITS):
    if _mover == MOVER_TABLE:  # the float planner knows no other
        CASES.append(("planner.tick:" + _name, lambda gait=_at: walking(gait)))
