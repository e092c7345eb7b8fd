"""The first walk: stand up, walk, turn, and say where the robot is. Places: sim, space, servos, can."""

import sys

from caramelo import Robot

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    robot.walk(0.05, seconds=3)
    robot.turn(deg=30)
    print(robot.odometry)
