"""Ten push-ups: all legs bend and stretch together, joint by joint at 50 Hz."""

import sys
from math import pi, sin

from caramelo import Robot

HZ, SECONDS, DEPTH_RAD = 50, 10.0, 0.25

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    start = robot.sensed.goals_rad
    deepest = 0.0
    for tick, now in enumerate(robot.stream(hz=HZ, seconds=SECONDS, joint_rad_s=2.0)):
        bend = DEPTH_RAD * sin(pi * tick / HZ) ** 2  # one a second
        legs = [[hip, thigh + bend, calf - 2 * bend] for hip, thigh, calf in zip(*[iter(start)] * 3, strict=True)]
        robot.set_joints([angle for leg in legs for angle in leg])
        deepest = max(deepest, start[2] - now.joints_rad[2])
    print(f"{SECONDS:.0f} push-ups, the calf bent by up to {deepest:.2f} rad")
