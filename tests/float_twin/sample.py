"""A sample of everything the float twin does, as a list of numbers: the same on CPython and on MicroPython."""

import math

from shared.gait.gaits import PAPER_TROT

from . import attitude, leg, planner, reach, swing
from .gait import Gait
from .si import Plain

# A body that moves evenly, also while legs swing, and swings of even samples: what the papers' trot is not.
EVEN_TROT = ((35, 100, 100, 0), ((360, 0, 46), (200, 9, 10), (360, 0, 46), (200, 6, 10)))


def robot(rate_hz):
    """Return a robot like Caramelo, per tick at this rate."""
    legs = []
    for number in range(4):
        side, fore = (1 if number % 2 else -1), (1 if number < 2 else -1)
        hip = [fore * 0.11455, side * 0.07, 0.0]
        legs.append(
            Plain(
                side_l1=side * 0.048, l1=0.048, l2=0.12, l3=0.12, knee=-1, hip=hip,
                rest=[hip[0], hip[1] + side * 0.048, -0.17], low=[-0.8, -0.3, -2.2], high=[0.8, 1.9, -0.9],
            )
        )  # fmt: skip
    return Plain(
        legs=legs,
        unit_m=2.0**-17,
        speed_unit=(1e-9, 1e-9, 1e-9),
        speed_max=(0.1 / rate_hz, 0.05 / rate_hz, 0.4 / rate_hz),
        speed_slew=(0.2 / rate_hz**2, 0.2 / rate_hz**2, 1.0 / rate_hz**2),
        pose_max=[0.04] * 3 + [0.35] * 3,
        pose_slew=[0.1 / rate_hz] * 3 + [1.0 / rate_hz] * 3,
        joint_speed_slow=0.8 / rate_hz,
        joint_speed_max=(5.8 / rate_hz, 5.8 / rate_hz, 6.5 / rate_hz),
        coupled=False,
        sit_z=-0.115,
        stride=0.12,
        gains=(0.3, 7.5, 0.006, 0.30, 0.45, rate_hz),
    )


def walk(rate_hz, gait):
    """Stand up, walk a curve with a tilting body, sit down; return the joints now and then."""
    made = planner.Planner(robot(rate_hz), [Gait(table, rate_hz) for table in (PAPER_TROT, EVEN_TROT)])
    command = Plain(mode=planner.STAND, gait=gait, speed=[0.04 / rate_hz, 0.01 / rate_hz, -0.2 / rate_hz])
    command.pose, command.balance, command.height_m = [0.01, 0.0, 0.01, 0.05, -0.03, 0.02], True, 0.0
    sensed = Plain(roll=0.0, pitch=0.0, attitude_ok=True, joints=[0.0, 0.6, -1.5] * 4, joints_ok=True)
    found = []
    for tick in range(14 * rate_hz):
        if made.state == planner.STANDING:
            command.mode = planner.WALK
        if tick > 9 * rate_hz:
            command.mode = planner.SIT
        sensed.roll, sensed.pitch = 0.05 * math.sin(tick / 7), 0.03 * math.cos(tick / 9)
        sensed.joints = made.tick(command, sensed)
        if tick % (rate_hz // 2) == 0:
            found += [float(made.state)] + sensed.joints
    return found


def filtered():
    """Return roll and pitch of a filter on a rolling body."""
    made = attitude.Attitude(2.7e-6, 16384, 0.02, 100.0, 2400, (66, 443), 5)
    found = []
    for tick in range(60):
        turning = 0 if tick < 5 else 900
        made.step((turning, -turning // 2, 30), (0, 20 * tick, 16300))
        found += made.angles()
    return found


def numbers():
    """Return all of it."""
    found = walk(20, 0) + walk(20, 1) + walk(25, 1) + filtered()
    found += swing.foot(0.3, (0, 0, 0), (0.05, 0, 0.03), 0.05)
    found += reach.clamp((0.3, 0.1, -0.2), 0.048, 0.12, 0.12)[0]
    found += leg.inverse((0.02, 0.05, -0.17), 0.048, 0.12, 0.12, -1)
    return found
