"""The robot as a URDF: for RViz and for other simulators. Links have inertia and simple shapes, joints limits.

A calf driven from the body (paper B) is an ordinary knee joint here: URDF knows no coupled drives, so its
effort and velocity are those of the drive seen from the knee.
"""

from collections.abc import Iterable
from xml.etree import ElementTree as Xml

from sim2d.model import PlanarRobot, ServoModel

from ...robot.model import JOINT_NAMES, LEG_NAMES, Link, Robot
from ...robot.plane import planar_robot
from .mjcf import PAYLOAD_HALF_M, drives

_COLOURS = {"trunk": "0.2 0.35 0.6 1", "limb": "0.3 0.3 0.3 1", "foot": "0.1 0.1 0.1 1", "load": "0.8 0.6 0.1 1"}


def urdf(robot: Robot, payload_kg: float = 0.0, voltage_V: float | None = None) -> str:
    """Return the URDF as XML text; the root is base_link, in the middle of the four hips."""
    plane = planar_robot(robot)
    root = Xml.Element("robot", name=robot.name)
    for name, rgba in _COLOURS.items():
        Xml.SubElement(Xml.SubElement(root, "material", name=name), "color", rgba=rgba)
    Xml.SubElement(root, "link", name="base_link")
    trunk = _link(root, "trunk", robot.links.trunk)
    _shape(trunk, "trunk", "box", {"size": _vector(robot.links.trunk.size_m)}, (0, 0, 0))
    _fixed(root, "trunk_joint", "base_link", "trunk", (0, 0, 0))
    _fixed(root, "imu_joint", "base_link", "imu_link", (0, 0, 0))
    Xml.SubElement(root, "link", name="imu_link")
    if payload_kg > 0:
        _add_payload(root, robot, payload_kg)
    for leg in range(4):
        _add_leg(root, robot, plane, leg, drives(plane, voltage_V))
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _link(root: Xml.Element, name: str, link: Link, side: int = 1, knee: int = -1) -> Xml.Element:
    """Add a link with its inertia: the file's link is a left elbow leg's, so y mirrors by side and x by knee."""
    x, y, z = link.com_m
    return _body(root, name, link.mass_kg, link.inertia_kg_m2, (-knee * x, side * y, z))


def _body(
    root: Xml.Element, name: str, mass_kg: float, moments: tuple[float, float, float], com_m: Iterable[float]
) -> Xml.Element:
    element = Xml.SubElement(root, "link", name=name)
    inertial = Xml.SubElement(element, "inertial")
    Xml.SubElement(inertial, "origin", xyz=_vector(com_m), rpy="0 0 0")
    Xml.SubElement(inertial, "mass", value=f"{mass_kg:.9g}")
    xx, yy, zz = (f"{moment:.9g}" for moment in moments)
    Xml.SubElement(inertial, "inertia", ixx=xx, iyy=yy, izz=zz, ixy="0", ixz="0", iyz="0")
    return element


def _shape(
    link: Xml.Element, colour: str, kind: str, size: dict[str, str], at_m: Iterable[float], collides: bool = True
) -> None:
    """Add a shape to be seen and, if it ``collides``, felt."""
    place = _vector(at_m)
    for role in ("visual", "collision") if collides else ("visual",):
        element = Xml.SubElement(link, role)
        Xml.SubElement(element, "origin", xyz=place, rpy="0 0 0")
        Xml.SubElement(Xml.SubElement(element, "geometry"), kind, size)
        if role == "visual":
            Xml.SubElement(element, "material", name=colour)


def _joint(root: Xml.Element, name: str, kind: str, parent: str, child: str, at_m: Iterable[float]) -> Xml.Element:
    element = Xml.SubElement(root, "joint", name=name, type=kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=child)
    Xml.SubElement(element, "origin", xyz=_vector(at_m), rpy="0 0 0")
    return element


def _fixed(root: Xml.Element, name: str, parent: str, child: str, at_m: Iterable[float]) -> None:
    _joint(root, name, "fixed", parent, child, at_m)


def _add_payload(root: Xml.Element, robot: Robot, mass_kg: float) -> None:
    x, y, z = PAYLOAD_HALF_M
    moments = (mass_kg / 3 * (y * y + z * z), mass_kg / 3 * (x * x + z * z), mass_kg / 3 * (x * x + y * y))
    load = _body(root, "payload", mass_kg, moments, (0, 0, 0))
    _shape(load, "load", "box", {"size": _vector((2 * x, 2 * y, 2 * z))}, (0, 0, 0), collides=False)
    _fixed(root, "payload_joint", "trunk", "payload", robot.links.trunk.payload_m)


def _add_leg(
    root: Xml.Element, robot: Robot, plane: PlanarRobot, leg: int, servos: tuple[ServoModel, ServoModel, ServoModel]
) -> None:
    """Add hip, thigh, calf and foot of a leg."""
    name, side = LEG_NAMES[leg], robot.side(leg)
    offset_m, thigh_m, calf_m = robot.geometry.links_m
    links = (robot.links.hip, robot.links.thigh, robot.links.calf)
    places = ((*robot.hip_m(leg), 0.0), (0.0, side * offset_m, 0.0), (0.0, 0.0, -thigh_m))
    parent = "trunk"
    for joint, part in enumerate(JOINT_NAMES):
        child = f"{name}_{part}"
        body = _link(root, child, links[joint], side, robot.knee_sign(leg))
        if joint > 0:
            length_m = (thigh_m, calf_m - plane.foot_radius_m)[joint - 1]
            size = {"radius": f"{plane.shank_radius_m:.9g}", "length": f"{length_m:.9g}"}
            _shape(body, "limb", "cylinder", size, (0, 0, -length_m / 2))
        hinge = _joint(root, f"{child}_joint", "revolute", parent, child, places[joint])
        fastest_rad_s = robot.actuator.fastest_rad_s * (robot.calf_drive.ratio if joint == 2 else 1.0)
        _limit(hinge, robot.joint_limits_rad(leg)[joint], servos[joint], joint, fastest_rad_s)
        parent = child
    # the foot's shape is the calf's: a reader may give a link with a shape and no inertia a mass of its own
    _shape(body, "foot", "sphere", {"radius": f"{plane.foot_radius_m:.9g}"}, (0, 0, -calf_m))
    Xml.SubElement(root, "link", name=f"{name}_foot")
    _fixed(root, f"{name}_foot_joint", parent, f"{name}_foot", (0, 0, -calf_m))


def _limit(
    hinge: Xml.Element, limits_rad: tuple[float, float], servo: ServoModel, joint: int, fastest_rad_s: float
) -> None:
    Xml.SubElement(hinge, "axis", xyz="1 0 0" if joint == 0 else "0 1 0")
    low, high = limits_rad
    Xml.SubElement(hinge, "limit", lower=f"{low:.9g}", upper=f"{high:.9g}", effort=f"{servo.stall_torque_Nm:.9g}",
                   velocity=f"{fastest_rad_s:.9g}")
    Xml.SubElement(hinge, "dynamics", damping=f"{servo.damping_Nms_rad:.9g}", friction=f"{servo.coulomb_Nm:.9g}")
