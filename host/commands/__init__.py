"""One file per group of commands. Each has ``register(app)``, which adds its commands to the app; ``_``: shared parts.

Importing one of these files must stay cheap, because `caramelo --help` imports all of them: numpy, pymunk,
the robot files and the like are imported inside the command functions. A panel is a heading in the help.
"""

WALK = "Walk"
ROBOTS = "Robots"
HARDWARE = "Servos, joints, boards"
CHECKS = "Checks and figures"

# The files whose panel stands first in the help: what a new user tries first.
FIRST = ("walk", "teleop")
