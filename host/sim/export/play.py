"""The changes of an honest drive to a MuJoCo model: play in its gear, the motor's braking, external torque.

A joint's play is a second hinge behind the first: the first turns with the rotor and has its armature and friction, the
second turns freely between stops, the flanks. A coupled calf's rotor turns with the rod: tendon over both of the
thigh's hinges and the calf's first.
"""

from xml.etree import ElementTree as Xml

from ...robot.actuators import Servo
from ...robot.model import Robot
from ..servos.law import LEAST_PLAY_RAD, Figures

PLAY = "_play"
LEAST_NM = 1e-6  # a joint without friction would have no row in MuJoCo's constraints


def make_honest(root: Xml.Element, robot: Robot, figures: Figures, names: list[str], voltage_V: float) -> None:
    """Change a model whose joints and drives have the names in this order."""
    joints = {joint.get("name", ""): (body, joint) for body in root.iter("body") for joint in body.findall("joint")}
    rods = {rod.get("name"): rod for rod in root.iter("fixed")}
    for index, (name, drive) in enumerate(zip(names, root.iter("general"), strict=True)):
        ratio = robot.calf_drive.ratio if index % 3 == 2 else 1.0
        body, joint = joints[name]
        half = max(figures.backlash_rad * ratio, LEAST_PLAY_RAD) / 2
        play = Xml.Element("joint", name=name + PLAY, type="hinge", axis=joint.get("axis", ""),
                           range=f"{-half:.9g} {half:.9g}")  # fmt: skip
        body.insert(list(body).index(joint) + 1, play)
        rod = rods.get(name.replace("_joint", "_rod"))
        if rod is not None:
            Xml.SubElement(rod, "joint", joint=name.replace("calf", "thigh") + PLAY, coef="1")
        most_Nm = figures.motor_stall_Nm / ratio
        turns = joint if rod is None else rod
        turns.set("frictionloss", f"{max(LEAST_NM, figures.coulomb_Nm / ratio):.9g}")
        if isinstance(robot.actuator, Servo):
            turns.set("damping", f"{figures.braking_Nms_rad / ratio**2:.9g}")
            drive.set("gainprm", "1")
            drive.set("biasprm", "0 0 0")
            most_Nm *= voltage_V / figures.voltage_V
        drive.set("forcerange", f"{-most_Nm:.9g} {most_Nm:.9g}")
