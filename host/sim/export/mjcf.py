"""The robot as a MuJoCo model (MJCF): masses, joints, limits, the servo law and the ground it stands on.

The servo is torque = clip(stiffness x error, +-stall) - damping x speed: a position actuator with a force
range, and the damping in the joint; a drive with a speed loop damps within its force range. A calf driven from the
body (paper B) is a tendon over thigh + calf.
It loads in its rest pose, which is also the keyframe "rest" with the goals that hold it.
Contacts: hard feet (impratio 100, solimp .99 .999) creep below 0.01 mm in 20 s of standing.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import radians
from xml.etree import ElementTree as Xml

from sim2d.model import GRAVITY_M_S2, PlanarRobot, ServoModel

from ...robot.coupling import to_motor
from ...robot.model import JOINT_NAMES, LEG_NAMES, Link, Robot, Vector
from ...robot.plane import drives, planar_robot
from ...robot.poses import rest_pose_rad
from ...robot.urdf import PAYLOAD_HALF_M
from ..servos.law import honest_figures
from .ground import Ground
from .play import make_honest

# The joints' end stops are this far outside the limits of the goals.
STOP_MARGIN_RAD = radians(3.0)
_SOLVER = {"solref": "0.004 1", "solimp": "0.99 0.999 0.0005 0.5 2", "condim": "3"}
_STOP = {"solreflimit": "0.02 1"}
_AXES = ("1 0 0", "0 1 0", "0 1 0")  # of hip, thigh and calf
_DRY = {"solreffriction": "0.004 1", "solimpfriction": "0.9999 0.9999 0.001 0.5 2"}


@dataclass(frozen=True)
class ModelOptions:
    """Options beside the robot file. ``friction`` None: the foot's own; ``voltage_V`` None: nominal.

    ``honest``: the gears have play, and who steps the model gives the drives' torque (host/sim/space/drives.py).
    """

    ground: Ground = field(default_factory=lambda: Ground("flat"))
    payload_kg: float = 0.0
    friction: float | None = None
    voltage_V: float | None = None
    dt_s: float = 0.001
    impratio: float = 100.0
    on_a_stand: bool = False
    at_rest: bool = True  # load in the rest pose; else with all joints at 0, for callers that place the robot
    honest: bool = False  # not with at_rest
    self_collision: bool = False  # else the robot's parts go through each other


def joint_names() -> list[str]:
    """Return the twelve joints' names in the core's order: FR_hip_joint, FR_thigh_joint ..."""
    return [f"{leg}_{joint}_joint" for leg in LEG_NAMES for joint in JOINT_NAMES]


def mjcf(robot: Robot, options: ModelOptions | None = None) -> str:
    """Return the model as XML text."""
    chosen = options or ModelOptions()
    plane = planar_robot(robot, chosen.friction)
    root = Xml.Element("mujoco", model=robot.name)
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    Xml.SubElement(
        root, "option", timestep=_number(chosen.dt_s), integrator="implicitfast", cone="elliptic",
        impratio=_number(chosen.impratio), gravity=f"0 0 {-GRAVITY_M_S2}", tolerance="1e-10",
    )
    Xml.SubElement(root, "size", memory="32M")
    Xml.SubElement(root, "statistic", center="0 0 0.1", extent="1")
    world = Xml.SubElement(root, "worldbody")
    Xml.SubElement(world, "light", pos="0 0 3")
    _add_ground(world, chosen.ground)
    _add_trunk(world, robot, plane, chosen)
    _add_drives(root, robot, plane, chosen.voltage_V)
    if chosen.self_collision:
        _let_collide(root)
    figures = honest_figures(robot.actuator) if chosen.honest else None
    if figures is not None:
        make_honest(root, robot, figures, joint_names(), chosen.voltage_V or figures.voltage_V)
    if chosen.at_rest:
        _add_rest(root, robot, chosen)
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode") + "\n"


def _number(value: float) -> str:
    return f"{value:.9g}"


def _vector(values: Iterable[float]) -> str:
    return " ".join(map(_number, values))


def _add_ground(world: Xml.Element, ground: Ground) -> None:
    Xml.SubElement(world, "geom", {**_SOLVER, "name": "ground", "type": "plane", "size": "50 50 0.1", "group": "2",
                                   "pos": _vector((0, 0, ground.floor_m)), "rgba": "0.75 0.72 0.66 1"})
    for i, block in enumerate(ground.blocks):
        parent, place = world, {"pos": _vector(block.centre_m), "quat": _vector(block.quaternion)}
        shape = {**_SOLVER, "name": f"ground{i}", "type": "box", "size": _vector(block.half_m), "group": "2",
                 "rgba": "0.6 0.55 0.48 1"}
        if block.mass_kg > 0:
            parent = Xml.SubElement(world, "body", {"name": f"stone{i}", **place})
            Xml.SubElement(parent, "freejoint")
            place = {"mass": _number(block.mass_kg)}
        Xml.SubElement(parent, "geom", {**shape, **place})


def _touching(friction: float) -> dict[str, str]:
    """Attributes of a part that touches the ground with its own friction, and never the robot itself."""
    return {**_SOLVER, "friction": f"{_number(friction)} 0.005 0.0001", "priority": "1", "contype": "0",
            "conaffinity": "1"}


def _let_collide(root: Xml.Element) -> None:
    """Let all parts that touch the ground touch each other, except neighbours: a thigh's top is in the trunk."""
    for geom in root.iter("geom"):
        if geom.get("priority"):
            geom.set("contype", "2")
            geom.set("conaffinity", "3")
    apart = Xml.SubElement(root, "contact")
    for leg in LEG_NAMES:
        Xml.SubElement(apart, "exclude", body1="trunk", body2=f"{leg}_thigh")


def _inertial(body: Xml.Element, link: Link, side: int = 1, knee: int = -1) -> None:
    """Add a link's mass: the file's link is a left elbow leg's, so y mirrors by side and x by knee."""
    x, y, z = link.com_m
    Xml.SubElement(body, "inertial", pos=_vector((-knee * x, side * y, z)), mass=_number(link.mass_kg),
                   diaginertia=_vector(link.inertia_kg_m2))


def _trunk_m(robot: Robot, options: ModelOptions) -> Vector:
    return 0.0, 0.0, robot.stance.rest_height_m + robot.geometry.foot_radius_m + 0.5 * options.on_a_stand


def _add_trunk(world: Xml.Element, robot: Robot, plane: PlanarRobot, options: ModelOptions) -> None:
    """Add the trunk at rest height, its payload, and the legs; a robot on a stand hangs half a metre up."""
    trunk = Xml.SubElement(world, "body", name="trunk", pos=_vector(_trunk_m(robot, options)))
    if not options.on_a_stand:
        Xml.SubElement(trunk, "freejoint", name="base")
    _inertial(trunk, robot.links.trunk)
    half = [size / 2 for size in robot.links.trunk.size_m]
    Xml.SubElement(trunk, "geom", {**_touching(plane.body_friction), "name": "trunk", "type": "box",
                                   "size": _vector(half), "rgba": "0.2 0.35 0.6 1"})
    Xml.SubElement(trunk, "site", name="imu")
    if options.payload_kg > 0:
        _add_payload(trunk, robot, options.payload_kg)
    for leg in range(4):
        _add_leg(trunk, robot, plane, leg, options)


def _add_payload(trunk: Xml.Element, robot: Robot, mass_kg: float) -> None:
    """Add an even box; it has mass and touches nothing."""
    body = Xml.SubElement(trunk, "body", name="payload", pos=_vector(robot.links.trunk.payload_m))
    x, y, z = PAYLOAD_HALF_M
    moments = (mass_kg / 3 * (y * y + z * z), mass_kg / 3 * (x * x + z * z), mass_kg / 3 * (x * x + y * y))
    Xml.SubElement(body, "inertial", pos="0 0 0", mass=_number(mass_kg), diaginertia=_vector(moments))
    Xml.SubElement(body, "geom", name="payload", type="box", size=_vector(PAYLOAD_HALF_M), contype="0",
                   conaffinity="0", rgba="0.8 0.6 0.1 1")


def _add_leg(trunk: Xml.Element, robot: Robot, plane: PlanarRobot, leg: int, options: ModelOptions) -> None:
    """Add hip, thigh and calf with their joints and the parts that touch the ground."""
    name, side, knee = LEG_NAMES[leg], robot.side(leg), robot.knee_sign(leg)
    offset_m, thigh_m, calf_m = robot.geometry.links_m
    links, servos = robot.links, drives(plane, options.voltage_V)
    hip = Xml.SubElement(trunk, "body", name=f"{name}_hip", pos=_vector((*robot.hip_m(leg), 0)))
    thigh = Xml.SubElement(hip, "body", name=f"{name}_thigh", pos=_vector((0, side * offset_m, 0)))
    calf = Xml.SubElement(thigh, "body", name=f"{name}_calf", pos=_vector((0, 0, -thigh_m)))
    bodies = (hip, thigh, calf)
    for joint, link in enumerate((links.hip, links.thigh, links.calf)):
        on_tendon = joint == 2 and plane.calf_on_torso
        hinge = _add_joint(bodies[joint], robot, leg, joint, None if on_tendon else servos[joint])
        if options.at_rest:
            rest = _number(rest_pose_rad(robot)[3 * leg + joint])
            bodies[joint].set("axisangle", f"{_AXES[joint]} {rest}")
            hinge.set("ref", rest)
        _inertial(bodies[joint], link, side, knee)
    touching, radius_m = _touching(plane.body_friction), plane.link_radius_m
    tube = {"type": "capsule", "size": _number(radius_m), "rgba": "0.3 0.3 0.3 1"}
    Xml.SubElement(hip, "geom", {**tube, "name": f"{name}_hip", "contype": "0", "conaffinity": "0",
                                 "fromto": _vector((0, 0, 0, 0, side * max(offset_m, radius_m), 0))})
    Xml.SubElement(thigh, "geom", {**touching, **tube, "name": f"{name}_thigh",
                                   "fromto": _vector((0, 0, 0, 0, 0, -thigh_m))})
    Xml.SubElement(calf, "geom", {**touching, **tube, "name": f"{name}_calf",
                                  "fromto": _vector((0, 0, 0, 0, 0, plane.foot_radius_m - calf_m))})
    Xml.SubElement(calf, "geom", {**_touching(plane.foot_friction), "name": f"{name}_foot", "type": "sphere",
                                  "size": _number(plane.foot_radius_m), "pos": _vector((0, 0, -calf_m)),
                                  "rgba": "0.1 0.1 0.1 1"})


def _add_joint(body: Xml.Element, robot: Robot, leg: int, joint: int, servo: ServoModel | None) -> Xml.Element:
    """Add a hinge and return it; without ``servo`` its drive sits on a tendon."""
    low, high = robot.joint_limits_rad(leg)[joint]
    passive = {} if servo is None else _passive(servo)
    return Xml.SubElement(body, "joint", {"name": f"{LEG_NAMES[leg]}_{JOINT_NAMES[joint]}_joint", "type": "hinge",
                                          "axis": _AXES[joint],
                                          "range": _vector((low - STOP_MARGIN_RAD, high + STOP_MARGIN_RAD)),
                                          **passive, **_STOP})


def _passive(servo: ServoModel) -> dict[str, str]:
    own = 0.0 if servo.speed_loop else servo.damping_Nms_rad
    return {"damping": _number(own), "armature": _number(servo.armature_kgm2),
            "frictionloss": _number(servo.coulomb_Nm), **_DRY}


def _add_drives(root: Xml.Element, robot: Robot, plane: PlanarRobot, voltage_V: float | None) -> None:
    """Add the twelve position actuators; a coupled calf's acts on a tendon of thigh + calf."""
    servos = drives(plane, voltage_V)
    tendons = Xml.SubElement(root, "tendon") if plane.calf_on_torso else None
    actuators = Xml.SubElement(root, "actuator")
    for index, joint_name in enumerate(joint_names()):
        servo, where = servos[index % 3], {"joint": joint_name}
        if tendons is not None and index % 3 == 2:
            rod = joint_name.replace("_joint", "_rod")
            tendon = Xml.SubElement(tendons, "fixed", {"name": rod, **_passive(servo)})
            Xml.SubElement(tendon, "joint", joint=joint_name.replace("calf", "thigh"), coef="1")
            Xml.SubElement(tendon, "joint", joint=joint_name, coef="1")
            where = {"tendon": rod}
        stiffness, stall = servo.stiffness_Nm_rad, servo.stall_torque_Nm
        damping = servo.damping_Nms_rad if servo.speed_loop else 0.0
        Xml.SubElement(actuators, "general", {
            "name": joint_name.removesuffix("_joint"), **where, "gaintype": "fixed", "biastype": "affine",
            "gainprm": _number(stiffness), "biasprm": _vector((0, -stiffness, -damping)),
            "forcerange": _vector((-stall, stall)),
        })


def _add_rest(root: Xml.Element, robot: Robot, options: ModelOptions) -> None:
    """Add the keyframe: every loose stone where it lies, the trunk above its feet, joints and goals at rest."""
    pose = rest_pose_rad(robot)
    places: list[float] = []
    for block in options.ground.blocks:
        if block.mass_kg > 0:
            places += [*block.centre_m, *block.quaternion]
    if not options.on_a_stand:
        places += [*_trunk_m(robot, options), 1.0, 0.0, 0.0, 0.0]
    goals = to_motor(robot, pose)
    keys = Xml.SubElement(root, "keyframe")
    Xml.SubElement(keys, "key", name="rest", qpos=_vector([*places, *pose]), ctrl=_vector(goals))
