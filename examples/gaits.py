"""Try every gait that is advised for the robot, and compare commanded with walked speed."""

import sys

from caramelo import Robot

SPEED_M_S, SECONDS = 0.05, 8.0

for gait, why_not in Robot(*sys.argv[1:]).gaits.items():
    if why_not:
        print(f"{gait:10} not advised: {why_not}")
        continue
    with Robot(*sys.argv[1:], gait=gait) as robot:
        robot.stand()
        robot.walk(SPEED_M_S, seconds=SECONDS)
        print(f"{gait:10} {1000 * robot.odometry.x_m / SECONDS:.0f} mm/s of {1000 * SPEED_M_S:.0f}")
