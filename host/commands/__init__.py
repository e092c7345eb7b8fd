"""One file per command or group of commands; files with ``_`` in front hold what several of them share.

A file holds the command, a function of the file's name, or ``GROUP`` with several. Importing one of these files must
stay cheap, because `caramelo --help` imports all of them: numpy, pymunk, the robot files and the like are imported
inside the command functions.
"""

WALK = "Walk"
ROBOTS = "Robots"
HARDWARE = "Servos, joints, boards"
CHECKS = "Checks and figures"

# File -> its panel, a heading in the help. What a new user tries first comes first.
PANELS = {
    "teleop": WALK, "walk": WALK, "bench": CHECKS, "board": HARDWARE, "calibrate": HARDWARE, "core": CHECKS,
    "experiment": CHECKS, "export": ROBOTS, "firmware": HARDWARE, "flash": HARDWARE, "health": HARDWARE,
    "identify": HARDWARE, "joints": HARDWARE, "log": WALK, "motor": HARDWARE, "pairings": WALK, "parity": CHECKS,
    "robots": ROBOTS, "servos": HARDWARE, "tune": CHECKS,
}  # fmt: skip
