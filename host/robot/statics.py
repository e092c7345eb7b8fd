"""What standing demands of a robot's drives, by virtual work: their torques, and how far the body sags on four feet.

A joint's torque is the change, with its angle, of the energy of the leg's links less the work of the ground's push on
the foot. Torques and stiffnesses are those of host/robot/drives.py: at the joints, or at thigh + calf for a calf whose
motor sits on the body.
"""

from sim2d.model import GRAVITY_M_S2

from .coupling import to_motor
from .drives import joint_drives
from .kinematics_si import Vector, leg_forward
from .mass import com_at_rest_m, leg_parts
from .model import Robot
from .poses import leg_pose_rad, leg_to_rad, rest_pose_rad

_STEP, _SHIFT_M = 1e-5, 1e-4  # rad and m, of the differences that replace derivatives
_NEWTON = 6  # steps: for the known robots, the last one moves the body by less than 1 um


def pushes_on_four_N(robot: Robot) -> list[float]:
    """Return the ground's push on each of four feet; the centre of mass decides how front and rear share the weight."""
    com_x_m, weight_N = com_at_rest_m(robot)[0], robot.mass_kg * GRAVITY_M_S2
    front, rear = (robot.hip_m(leg)[0] + robot.stance.foot_forward_m for leg in (0, 2))
    on_front = weight_N * (com_x_m - rear) / (front - rear)
    return [on_front / 2, on_front / 2, (weight_N - on_front) / 2, (weight_N - on_front) / 2]


def push_on_two_N(robot: Robot) -> float:
    """Return the ground's push on each foot of a diagonal that carries the robot."""
    return robot.mass_kg * GRAVITY_M_S2 / 2


def torques_Nm(robot: Robot, leg: int, push_N: float) -> Vector:
    """Return the torques that a leg at rest holds, hip, thigh and calf, with a push straight up on its foot."""
    pose = leg_pose_rad(robot, leg, robot.stance.rest_height_m)
    hip, thigh, calf = (load_slope_Nm(robot, leg, pose, joint, push_N) for joint in range(3))
    return hip, thigh - calf if robot.calf_drive.coupled else thigh, calf


def torque_shares(robot: Robot, pushes_N: list[float]) -> Vector:
    """Return the largest torque of hips, thighs and calves over the legs, as a share of the drives' at standstill."""
    stall = [drive.stall_torque_Nm for drive in joint_drives(robot)]
    legs = [torques_Nm(robot, leg, push_N) for leg, push_N in enumerate(pushes_N)]
    hip, thigh, calf = (max(abs(leg[joint]) for leg in legs) / stall[joint] for joint in range(3))
    return hip, thigh, calf


def sag_m(robot: Robot) -> float | None:
    """Return how far the body sinks on four feet that do not slip, without feed-forward; None if its legs fold up.

    Newton's method finds the least energy of the drives' springs and the weight. If all knees point the same way, the
    body also moves back as it sinks; otherwise it can't.
    """
    down_m = back_m = 0.0
    for _ in range(_NEWTON):
        found = _newton_step_m(robot, down_m, back_m)
        if found is None:
            return None
        down_m, back_m = down_m + found[0], back_m + found[1]
    return down_m


def _newton_step_m(robot: Robot, down_m: float, back_m: float) -> tuple[float, float] | None:
    """Return the step from a moved body towards the least energy; None if there is no minimum, or no such pose."""
    steps = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)]
    energies = [_energy_J(robot, down_m + a * _SHIFT_M, back_m + b * _SHIFT_M) for a, b in steps]
    known = [energy for energy in energies if energy is not None]
    if len(known) < len(steps):
        return None
    here, lower, higher, behind, ahead, *corners = known
    slope_down, slope_back = (lower - higher) / 2, (behind - ahead) / 2
    bend_down, bend_back = lower + higher - 2 * here, behind + ahead - 2 * here
    both = (corners[0] - corners[1] - corners[2] + corners[3]) / 4
    firm = bend_down * bend_back - both**2
    if firm <= 0 or bend_down <= 0:
        return None
    down = both * slope_back - bend_back * slope_down
    back = both * slope_down - bend_down * slope_back
    return down / firm * _SHIFT_M, back / firm * _SHIFT_M


def load_slope_Nm(robot: Robot, leg: int, pose: Vector, joint: int, push_N: float) -> float:
    """Return the derivative of a leg's energy by one joint's angle: the torque that holds that joint, N m."""
    energies = []
    for step in (_STEP, -_STEP):
        joints = [angle + step * (at == joint) for at, angle in enumerate(pose)]
        turned = (joints[0], joints[1], joints[2])
        foot_z_m = leg_forward(robot.geometry.links_m, robot.side(leg), turned)[2]
        links_J = sum(mass * GRAVITY_M_S2 * centre[2] for mass, centre in leg_parts(robot, leg, turned))
        energies.append(links_J - push_N * foot_z_m)
    return (energies[0] - energies[1]) / (2 * _STEP)


def _energy_J(robot: Robot, down_m: float, back_m: float) -> float | None:
    """Return the energy of the drives' springs, whose goals are the rest pose, and of the weight, of a moved body.

    None if a leg is too long or too short for it.
    """
    height_m, rest, now = robot.stance.rest_height_m, rest_pose_rad(robot), list[float]()
    trunk = robot.links.trunk
    weight_J = trunk.mass_kg * GRAVITY_M_S2 * (trunk.com_m[2] - down_m)
    for leg in range(4):
        x, y, z = robot.foot_m(leg, height_m)
        pose = leg_to_rad(robot, leg, (x + back_m, y, z + down_m))
        if pose is None:
            return None
        now += pose
        weight_J += sum(mass * GRAVITY_M_S2 * (at[2] - down_m) for mass, at in leg_parts(robot, leg, pose))
    stiffness = [drive.stiffness_Nm_rad for drive in joint_drives(robot)] * 4
    turned = zip(stiffness, to_motor(robot, now), to_motor(robot, rest), strict=True)
    return weight_J + sum(k * (angle - goal) ** 2 / 2 for k, angle, goal in turned)
