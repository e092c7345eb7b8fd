"""Joints inside real MicroPython VMs: the robot's way, and every frame on its bus, are those of CPython's joints."""

import pytest

from host.robot.file import load_robot
from host.sim.joints.sim_robot import SimRobot
from host.sim.joints.vm_joint import VmInside
from host.util.errors import UserError
from tests.marks import NEEDS_UNIX

from .robot import Walker

NODES = (1, 5, 9, 11)  # a hip, two thighs without a joint encoder, a calf, of all four legs

pytestmark = NEEDS_UNIX


def walked(in_vm):
    """Arm, stand up, walk on two diagonals and lose a joint's supply; return every angle and every frame on the bus."""
    frames, angles = [], []
    with Walker(in_vm=in_vm) as walker:
        walker.sim.bus.log = lambda time_us, identifier, data: frames.append((time_us, identifier, data))
        walker.sim.each_ms.append(lambda ms: angles.append(tuple(walker.sim.body.angle_rad)))
        walker.arm()
        walker.go(1.6, mode="stand")
        walker.go(0.6)
        walker.sim.joints[NODES[1] - 1].power_cycle()
        walker.bus.run_for(0.2)
        inside = [joint.node for joint in walker.sim.joints if isinstance(joint.inside, VmInside)]
        return inside, angles, frames


def test_four_joints_in_vms_move_the_robot_as_cpythons_do_to_the_bit():
    inside, angles, frames = walked(NODES)
    assert inside == list(NODES)
    _, expected_angles, expected_frames = walked(())
    assert len(angles) > 2500
    assert len(frames) > 7_000
    assert angles == expected_angles
    assert frames == expected_frames


def test_a_vm_that_is_gone_is_told():
    sim = SimRobot(load_robot("parallel"), in_vm=(3,))
    try:
        inside = sim.joints[2].inside
        inside._process.kill()
        with pytest.raises(UserError, match="MicroPython VM has ended"):
            sim.advance_ms(2)
    finally:
        sim.close()
