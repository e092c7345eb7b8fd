"""Which joint works hardest while the robot walks: the root mean square of each one's share of its stall torque."""

import sys
from math import sqrt

from caramelo import JOINT_NAMES, Robot

with Robot(*sys.argv[1:]) as robot:
    robot.stand()
    rows = []
    for now in robot.stream(seconds=6):
        robot.set_speed(0.05)
        rows.append(now.load)
    for name, loads in sorted(zip(JOINT_NAMES, zip(*rows, strict=True), strict=True)):
        share = sqrt(sum(load**2 for load in loads) / len(loads))
        print(f"{name:9} {100 * share:3.0f} % {'#' * round(50 * share)}")
