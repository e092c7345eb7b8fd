"""The robot as a URDF, for RViz and other simulators. Links have inertia and simple shapes, joints have limits.

A calf driven from the body (paper B) is an ordinary knee joint here: URDF knows no coupled drives, so its
effort and velocity are those of the drive seen from the knee.
"""

from collections.abc import Iterable
from math import pi
from xml.etree import ElementTree as Xml

from sim2d.model import ServoModel

from .model import LEG_NAMES, Link, Robot
from .plane import drives, planar_robot
from .shapes import COLOURS, ROOT_LINK, Frame, Shape, frames, shapes

PAYLOAD_HALF_M = (0.06, 0.05, 0.025)


def urdf(robot: Robot, payload_kg: float = 0.0, voltage_V: float | None = None) -> str:
    """Return the URDF as XML text; the root is base_link, in the middle of the four hips."""
    servos = drives(planar_robot(robot), voltage_V)
    root = Xml.Element("robot", name=robot.name)
    for name, rgba in COLOURS.items():
        Xml.SubElement(Xml.SubElement(root, "material", name=name), "color", rgba=_vector(rgba))
    Xml.SubElement(root, "link", name=ROOT_LINK)
    _joint(root, "imu_joint", "fixed", ROOT_LINK, "imu_link", (0, 0, 0))
    Xml.SubElement(root, "link", name="imu_link")
    if payload_kg > 0:
        _add_payload(root, robot, payload_kg)
    seen = list(shapes(robot))
    for frame in frames(robot):
        body = _add_link(root, robot, frame)
        for shape in seen:
            if shape.link == frame.name:
                _shape(body, shape)
        if frame.joint is None:
            _joint(root, f"{frame.name}_joint", "fixed", frame.parent, frame.name, frame.at_m)
        else:
            _add_hinge(root, robot, frame, frame.joint, servos)
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _add_link(root: Xml.Element, robot: Robot, frame: Frame) -> Xml.Element:
    """Add a link with its inertia: the file's link is a left elbow leg's, so y mirrors by side and x by knee.

    A foot has none: some readers would give a link with a shape but no inertia a mass of its own.
    """
    if frame.name == "trunk":
        trunk = robot.links.trunk
        return _body(root, frame.name, trunk.mass_kg, trunk.inertia_kg_m2, trunk.com_m)
    if frame.joint is None:
        return Xml.SubElement(root, "link", name=frame.name)
    leg = LEG_NAMES.index(frame.name.partition("_")[0])
    link: Link = getattr(robot.links, frame.name.partition("_")[2])
    x, y, z = link.com_m
    com_m = (-robot.knee_sign(leg) * x, robot.side(leg) * y, z)
    return _body(root, frame.name, link.mass_kg, link.inertia_kg_m2, com_m)


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


def _shape(link: Xml.Element, shape: Shape) -> None:
    """Add a visible shape, and the same for collisions if it collides."""
    turned = _vector((pi / 2, 0, 0)) if shape.across else "0 0 0"
    for role in ("visual", "collision") if shape.collides else ("visual",):
        element = Xml.SubElement(link, role)
        Xml.SubElement(element, "origin", xyz=_vector(shape.at_m), rpy=turned)
        Xml.SubElement(Xml.SubElement(element, "geometry"), shape.kind, _size(shape))
        if role == "visual":
            Xml.SubElement(element, "material", name=shape.colour)


def _size(shape: Shape) -> dict[str, str]:
    if shape.kind == "box":
        return {"size": _vector(shape.size_m)}
    return {name: f"{value:.9g}" for name, value in zip(("radius", "length"), shape.size_m, strict=False)}


def _joint(root: Xml.Element, name: str, kind: str, parent: str, child: str, at_m: Iterable[float]) -> Xml.Element:
    element = Xml.SubElement(root, "joint", name=name, type=kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=child)
    Xml.SubElement(element, "origin", xyz=_vector(at_m), rpy="0 0 0")
    return element


def _add_payload(root: Xml.Element, robot: Robot, mass_kg: float) -> None:
    x, y, z = PAYLOAD_HALF_M
    moments = (mass_kg / 3 * (y * y + z * z), mass_kg / 3 * (x * x + z * z), mass_kg / 3 * (x * x + y * y))
    load = _body(root, "payload", mass_kg, moments, (0, 0, 0))
    _shape(load, Shape("payload", "box", (2 * x, 2 * y, 2 * z), (0.0, 0.0, 0.0), "load", collides=False))
    _joint(root, "payload_joint", "fixed", "trunk", "payload", robot.links.trunk.payload_m)


def _add_hinge(
    root: Xml.Element, robot: Robot, frame: Frame, joint: int, servos: tuple[ServoModel, ServoModel, ServoModel]
) -> None:
    leg, part = divmod(joint, 3)
    hinge = _joint(root, f"{frame.name}_joint", "revolute", frame.parent, frame.name, frame.at_m)
    fastest_rad_s = robot.actuator.fastest_rad_s * (robot.calf_drive.ratio if part == 2 else 1.0)
    (low, high), servo = robot.joint_limits_rad(leg)[part], servos[part]
    Xml.SubElement(hinge, "axis", xyz="0 1 0" if frame.axis else "1 0 0")
    Xml.SubElement(hinge, "limit", lower=f"{low:.9g}", upper=f"{high:.9g}", effort=f"{servo.stall_torque_Nm:.9g}",
                   velocity=f"{fastest_rad_s:.9g}")
    Xml.SubElement(hinge, "dynamics", damping=f"{servo.damping_Nms_rad:.9g}", friction=f"{servo.coulomb_Nm:.9g}")
