"""Give a paw: shift the body away from the front right leg, lift it and wave."""

import sys
from math import sin

from caramelo import Robot

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    robot.pose(x_m=-0.03, y_m=0.03)
    thigh, calf = robot.sensed.goals_rad[1:3]
    for tick, _ in enumerate(robot.stream(hz=50, seconds=4.0)):
        up = min(1.0, tick / 50)
        robot.set_joints({"FR_thigh": thigh - 0.4 * up, "FR_calf": calf - 0.4 * up + 0.15 * up * sin(tick / 5)})
    print(f"paw up: calf at {robot.sensed.joints_rad[2]:.2f} rad, state {robot.sensed.state}")
