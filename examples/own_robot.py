"""A robot of one's own is a file: take Caramelo's, make its body heavier, check it by loading it, walk it."""

import sys
from pathlib import Path

from caramelo import Error, Robot, robot_path

mine = Path("mine.toml")
text = robot_path("caramelo").read_text()
mine.write_text(text.replace("mass_kg = 1.284", "mass_kg = 1.6").replace('name = "caramelo"', 'name = "mine"', 1))
with Robot(*sys.argv[1:2], robot=mine) as robot:
    robot.stand()
    robot.walk(0.05, seconds=3)
    print(f"{robot.name} walked {robot.odometry.x_m:.2f} m")

mine.write_text(mine.read_text().replace("mass_kg = 1.6", "mass_kg = -1"))
try:
    Robot(robot=mine)
except Error as error:
    print(f"refused: {error}")
