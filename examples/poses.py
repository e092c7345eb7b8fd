"""Move the body over standing feet: down, up, and round in a circle with roll and pitch."""

import sys
from math import cos, radians, sin

from caramelo import Robot

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    for z_m in (-0.03, 0.01, 0.0):
        robot.pose(z_m=z_m)
    for angle_deg in range(0, 361, 30):
        angle = radians(angle_deg)
        robot.pose(roll_deg=6 * sin(angle), pitch_deg=6 * cos(angle))
    robot.pose()
    print(f"back in its stance: {robot.sensed.state}")
