"""Go to a point: look where it is ten times a second and steer for it."""

import sys
from math import atan2, degrees, hypot

from caramelo import Robot

GOAL_M = (0.3, 0.15)

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    for now in robot.stream(hz=10, seconds=60):
        at = now.odometry
        dx_m, dy_m = GOAL_M[0] - at.x_m, GOAL_M[1] - at.y_m
        if hypot(dx_m, dy_m) < 0.03:
            break
        aside = atan2(dy_m, dx_m) - at.yaw_rad
        robot.set_speed(0.05 if abs(aside) < 0.5 else 0.0, wz_rad_s=max(-0.3, min(0.3, aside)))
    print(f"at x {at.x_m:.2f} m, y {at.y_m:.2f} m, heading {degrees(at.yaw_rad):.0f} deg")
