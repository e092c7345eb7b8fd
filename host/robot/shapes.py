"""The robot as a tree of links with solid shapes, which URDF, records and viewers draw."""

from collections.abc import Iterator
from dataclasses import dataclass

from .model import JOINT_NAMES, LEG_NAMES, Robot, Vector
from .plane import planar_robot

ROOT_LINK = "base_link"  # in the middle of the four hips
COLOURS = {  # red, green, blue, opacity
    "trunk": (0.2, 0.35, 0.6, 1.0),
    "limb": (0.3, 0.3, 0.3, 1.0),
    "foot": (0.1, 0.1, 0.1, 1.0),
    "load": (0.8, 0.6, 0.1, 1.0),
}


@dataclass(frozen=True)
class Frame:
    """A link's place on its parent, m; ``joint`` 0 .. 11 turns it about x (``axis`` 0) or y (1); None: it is fixed."""

    name: str
    parent: str
    at_m: Vector
    joint: int | None = None
    axis: int = 0


@dataclass(frozen=True)
class Shape:
    """A solid on a link, its middle at ``at_m``.

    ``size_m``: of a box x, y, z; of a sphere its radius; of a cylinder radius and length, along z, or y if ``across``.
    """

    link: str
    kind: str
    size_m: tuple[float, ...]
    at_m: Vector
    colour: str
    across: bool = False
    collides: bool = True


def frames(robot: Robot) -> Iterator[Frame]:
    """Yield all links below ROOT_LINK, parents before their children."""
    yield Frame("trunk", ROOT_LINK, (0.0, 0.0, 0.0))
    offset_m, thigh_m, calf_m = robot.geometry.links_m
    for leg, name in enumerate(LEG_NAMES):
        places = ((*robot.hip_m(leg), 0.0), (0.0, robot.side(leg) * offset_m, 0.0), (0.0, 0.0, -thigh_m))
        parent = "trunk"
        for part, (joint, at_m) in enumerate(zip(JOINT_NAMES, places, strict=True)):
            yield Frame(f"{name}_{joint}", parent, at_m, 3 * leg + part, min(part, 1))
            parent = f"{name}_{joint}"
        yield Frame(f"{name}_foot", parent, (0.0, 0.0, -calf_m))


def shapes(robot: Robot) -> Iterator[Shape]:
    """Yield the robot's visible shapes; a foot's shape belongs to the calf."""
    plane = planar_robot(robot)
    offset_m, thigh_m, calf_m = robot.geometry.links_m
    radius_m, foot_m = plane.link_radius_m, plane.foot_radius_m
    yield Shape("trunk", "box", robot.links.trunk.size_m, (0.0, 0.0, 0.0), "trunk")
    for leg, name in enumerate(LEG_NAMES):
        hip_m = max(offset_m, radius_m)
        middle_m = robot.side(leg) * hip_m / 2
        yield Shape(f"{name}_hip", "cylinder", (radius_m, hip_m), (0.0, middle_m, 0.0), "limb", True, collides=False)
        for part, length_m in (("thigh", thigh_m), ("calf", calf_m - foot_m)):
            yield Shape(f"{name}_{part}", "cylinder", (radius_m, length_m), (0.0, 0.0, -length_m / 2), "limb")
        yield Shape(f"{name}_calf", "sphere", (foot_m,), (0.0, 0.0, -calf_m), "foot")
