"""The folder every runtime starts from: shared/ and the vectors, with both robots as integer blocks."""

import shutil
from pathlib import Path
from typing import Any

from shared.joint.layout import SINE_SIZE
from shared.record import pack

from ... import ROOT
from ...boards.build.leaves import behind_leaves
from ...boards.build.source import read_modules
from ...robot.actuators import Bldc
from ...robot.file import driven_names, load_robot
from ...robot.joint_gains import joint_blocks
from ...robot.joint_units import JointSetup
from ...robot.model import Robot
from ...robot.scale import attitude_block, core_params

RATES_HZ = (None, 20, 500)  # the robot's own, and the ends of what the planner allows
# Legs that no robot file has: links of unequal length, knees in front.
OTHER_LEGS: tuple[dict[str, Any], ...] = (
    {"thigh_m": 0.1, "calf_m": 0.14, "knee_configuration": "elbow-knee"},
    {"thigh_m": 0.13, "calf_m": 0.11, "knee_configuration": "full-knee"},
)
# Joints with the encoder at the joint and without, in both senses of turning.
JOINT_SETUPS: tuple[dict[str, Any], ...] = ({"has_joint_encoder": True}, {"has_joint_encoder": False, "sign": -1})
PROBE = Path(__file__).with_name("probe")


def gather(work: Path, root: Path = ROOT) -> Path:
    """Return a new folder in ``work`` that holds the packages ``shared`` and ``probe``; probes import leaves first."""
    sources = work / "sources"
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root / "shared", sources / "shared", ignore=skip)
    shutil.copytree(PROBE, sources / "probe", ignore=skip)
    (sources / "probe" / "robots.py").write_text(robot_blocks())
    modules = read_modules(sources, ("shared", "probe"))
    for module in modules.values():
        if module.path.startswith("probe/"):
            (sources / module.path).write_bytes(behind_leaves(module, modules))
    return sources


def add_floats(tree: Path) -> bool:
    """Copy the float reference into a tree; False if there is none, as in an installation without the tests."""
    twin = ROOT / "tests" / "float_twin"
    if twin.is_dir():
        shutil.copytree(twin, tree / "float_twin", ignore=shutil.ignore_patterns("__pycache__"))
    return twin.is_dir()


def robot_blocks() -> str:
    """Return a module with every robot that is driven as the core's blocks: a VM cannot read the files itself."""
    robots = [load_robot(name) for name in driven_names()]
    params = [core_params(robot, rate_hz) for robot in robots for rate_hz in RATES_HZ]
    params += [core_params(_with_legs(robots[0], **legs)) for legs in OTHER_LEGS]
    attitudes = [attitude_block(robot, rate_hz) for robot in robots for rate_hz in RATES_HZ]
    joints = [_joint_blocks(**setup) for setup in JOINT_SETUPS]
    return (
        '"""Every robot at its own rate and at the ends of the range. Generated: do not edit."""\n\n'
        "from shared.sense.attitude import Attitude\n"
        "from shared.joint.layout import SINE_SIZE, CurrentLoop, JointSettings\n"
        "from shared.joint.commutation import fill_sine\n"
        "from shared.body.params import Params\n"
        "from shared.record import unpack\n"
        "from shared.runtime import zeros\n\n\n"
        "def _loop(values) -> CurrentLoop:\n"
        "    made = unpack(CurrentLoop(), list(values) + [0] * SINE_SIZE)\n"
        "    fill_sine(made)\n"
        "    return made\n\n\n"
        f"PARAMS = {_listing('Params', params)}\n"
        f"ATTITUDES = {_listing('Attitude', attitudes)}\n"
        f"JOINTS = ({''.join(joints)})\n"
    )


def _joint_blocks(**setup: Any) -> str:
    """Return the text of loop, settings and the thermistor curve of a joint of the robot that has brushless ones."""
    actuator = load_robot("parallel").actuator
    assert isinstance(actuator, Bldc)
    blocks = joint_blocks(actuator, JointSetup(lower_rad=-1.0, upper_rad=1.9, **setup))
    loop, settings, curve = (tuple(pack(block)) for block in (blocks.loop, blocks.settings, blocks.curve))
    return f"(_loop({loop[:-SINE_SIZE]}), unpack(JointSettings(), {settings}), unpack(zeros({len(curve)}), {curve})), "


def _with_legs(robot: Robot, **legs: Any) -> Robot:
    return robot.model_copy(update={"geometry": robot.geometry.model_copy(update=legs)})


def _listing(kind: str, blocks: list[Any]) -> str:
    rows = "".join(f"    unpack({kind}(), {tuple(pack(block))}),\n" for block in blocks)
    return f"(\n{rows})"
