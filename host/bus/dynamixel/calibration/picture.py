"""A picture for the person at the robot: a leg as text, drawn from the robot's own geometry.

``#`` is the leg at rest, ``+`` the same leg with a larger angle of one joint. Thigh and calf are seen from the
robot's left side, hips from behind. Signs as in the robot file: x forward, y left, z up.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import radians

from ....robot.kinematics_si import leg_forward
from ....robot.model import JOINT_NAMES, LEG_NAMES, Robot
from ....robot.poses import rest_pose_rad

WIDTH, HEIGHT = 49, 15
CELL = 0.5  # a character is half as wide as it is high
SHOWN_RAD = radians(20.0)
POINTS = 60  # drawn per link: more than a link has cells

Point = tuple[float, float]


def leg_points(robot: Robot, leg: int, pose_rad: Sequence[float], from_behind: bool) -> list[Point]:
    """Return hip axis, thigh joint, knee and foot as (to the right, up) in m, on the page."""
    l1, l2, l3 = robot.geometry.links_m
    hip, thigh, calf = pose_rad
    ends = (l1, 0.0, 0.0), (l1, l2, 0.0), (l1, l2, l3)
    chain = [leg_forward(links_m, robot.side(leg), (hip, thigh, calf)) for links_m in ends]
    return [(0.0, 0.0), *((-y, z) for _, y, z in chain)] if from_behind else [(-x, z) for x, _, z in chain]


def picture(robot: Robot, joint: int) -> str:
    """Return the drawing of a joint, with the way its leg goes when the angle grows."""
    leg, kind = divmod(joint, 3)
    from_behind = kind == 0
    rest = rest_pose_rad(robot)[3 * leg : 3 * leg + 3]
    larger = [angle + SHOWN_RAD * (k == kind) for k, angle in enumerate(rest)]
    canvas = [[" "] * WIDTH for _ in range(HEIGHT)]
    scale = (HEIGHT - 2) / (1.3 * robot.stance.rest_height_m)
    _draw(canvas, leg_points(robot, leg, larger, from_behind), scale, "+")
    _draw(canvas, leg_points(robot, leg, rest, from_behind), scale, "#")
    for column in range(WIDTH // 2 - 12, WIDTH // 2 + 13):
        canvas[0][column] = "="
    sides = ("left", "right") if from_behind else ("front", "rear")
    canvas[0][: len(sides[0])] = sides[0]
    canvas[0][-len(sides[1]) :] = sides[1]
    seen = "from behind" if from_behind else "from the robot's left side"
    lines = ["".join(row).rstrip() for row in canvas]
    title = f"{LEG_NAMES[leg]} {JOINT_NAMES[kind]}, seen {seen}: # at rest, + with a larger angle"
    return "\n".join([title, *lines, f"a larger angle moves the foot {words(joint)}"])


def _draw(canvas: list[list[str]], points: list[Point], scale: float, mark: str) -> None:
    for start, end in pairwise(points):
        for k in range(POINTS + 1):
            right = start[0] + (end[0] - start[0]) * k / POINTS
            up = start[1] + (end[1] - start[1]) * k / POINTS
            column, row = round(WIDTH // 2 + right * scale / CELL), 1 + round(-up * scale)
            if 0 <= column < WIDTH and 0 <= row < HEIGHT:
                canvas[row][column] = mark
    column, row = round(WIDTH // 2 + points[-1][0] * scale / CELL), 1 + round(-points[-1][1] * scale)
    if 0 <= column < WIDTH and 0 <= row < HEIGHT:
        canvas[row][column] = "O" if mark == "#" else "@"


def words(joint: int) -> str:
    """Return where the foot goes when the angle grows."""
    return "to the robot's LEFT" if joint % 3 == 0 else "to the REAR"


def reference_words(robot: Robot, joint: int) -> str:
    """Return in words where to put a joint by hand so that its angle is the reference."""
    leg, kind = divmod(joint, 3)
    if kind == 0:
        return f"{LEG_NAMES[leg]}: seen from behind, the leg hangs straight down, neither out nor in"
    if kind == 1:
        return f"{LEG_NAMES[leg]}: the thigh points straight down"
    side = "in front of" if robot.knee_sign(leg) < 0 else "behind"
    return f"{LEG_NAMES[leg]}: thigh and calf make a right angle, the foot {side} the knee"
