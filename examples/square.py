"""Walk a square of 20 cm and say how far from its start it closes, by the robot's own reckoning."""

import sys
from math import hypot

from caramelo import Robot

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    for side in range(4):
        robot.walk(0.08, distance_m=0.2)
        robot.turn(deg=90, wz_rad_s=0.6)
        print(f"corner {side + 1}: x {robot.odometry.x_m:.2f} m, y {robot.odometry.y_m:.2f} m")
    print(f"closed within {hypot(robot.odometry.x_m, robot.odometry.y_m):.2f} m")
