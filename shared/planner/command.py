"""The driver's command, limited and slewed: nothing that a driver sends acts at once.

A command is one block. Its speeds and its body pose are slewed within the limits of gait and robot, so a step of the
stick becomes a ramp of the robot.
"""

from ..body.axes import POSE_AXES, TWIST_AXES, Pose, Twist
from ..body.params import Params
from ..num.fixed import saturate
from ..record import field, part, record
from ..runtime import const, hot


@record
class Command:
    """What a driver wants; the planner limits and slews it."""

    mode: int = field("", "MODE_...")
    gait: int = field("", "index into gaits.GAITS")
    speed: Twist = part(Twist, "walking speed")
    pose: Pose = part(Pose, "of the body over its feet")
    balance: int = field("", "1: keep the body level by the measured attitude")
    height: int = field("lu", "swing height; 0: the gait's own")


COMMAND_SIZE = const(13)  # integers of a command in a frame, in the order of its declaration

MODE_LIMP = const(0)  # drive nothing: the joints are not held
MODE_STAND = const(1)
MODE_WALK = const(2)
MODE_SIT = const(3)
MODE_FOLD = const(4)  # a robot that lies limp on its belly folds its legs, then sits; otherwise as MODE_SIT


@hot
def copy_command(command: Command, copy: Command) -> None:
    """Copy ``command`` into ``copy``."""
    copy.mode = command.mode
    copy.gait = command.gait
    copy.balance = command.balance
    copy.height = command.height
    for axis in range(TWIST_AXES):
        copy.speed[axis] = command.speed[axis]
    for axis in range(POSE_AXES):
        copy.pose[axis] = command.pose[axis]


@hot
def slew(now: int, wanted: int, step: int) -> int:
    """Return ``now`` moved towards ``wanted`` by at most ``step`` (>= 0). Exact, any unit within +-2^29."""
    if wanted > now + step:
        return now + step
    if wanted < now - step:
        return now - step
    return wanted


@hot
def slew_speed_axis(now: int, commanded: int, most: int, halves: int, step: int) -> int:
    """Return ``now`` slewed for one tick towards halves/2 of ``commanded``, which is first limited to +-``most``.

    Half of an odd speed is rounded towards 0, so that left and right mirror each other.
    """
    if commanded > most or commanded < -most:
        commanded = saturate(commanded, -most, most)
    commanded *= halves
    if commanded < 0:
        commanded = -(-commanded >> 1)
    else:
        commanded >>= 1
    if now == commanded:
        return now
    return slew(now, commanded, step)


@hot
def slew_speed(params: Params, most: Twist, command: Command, halves: int, speed: Twist) -> int:
    """Slew ``speed`` for one tick towards halves/2 of the command; return 1 if it is then 0 on every axis.

    halves: 0 to stop, 1 or 2 for half or all of the command, which is first limited to ``most``.
    """
    speed.vx = slew_speed_axis(speed.vx, command.speed.vx, most.vx, halves, params.speed_slew.vx)
    speed.vy = slew_speed_axis(speed.vy, command.speed.vy, most.vy, halves, params.speed_slew.vy)
    speed.wz = slew_speed_axis(speed.wz, command.speed.wz, most.wz, halves, params.speed_slew.wz)
    if speed.vx or speed.vy or speed.wz:
        return 0
    return 1


@hot
def is_posed(command: Command, pose: Pose) -> int:
    """Return 1 if ``pose`` equals the commanded pose, as in most ticks; else 0."""
    commanded = command.pose
    if pose.x != commanded.x or pose.y != commanded.y or pose.z != commanded.z:
        return 0
    if pose.roll != commanded.roll or pose.pitch != commanded.pitch or pose.yaw != commanded.yaw:
        return 0
    return 1


@hot
def slew_pose(params: Params, command: Command, standing: int, pose: Pose) -> int:
    """Slew ``pose`` for one tick towards the commanded pose, or towards 0 unless ``standing``; return 1 if it moved."""
    moves = 0
    for axis in range(POSE_AXES):
        wanted = 0
        if standing:
            top = params.pose_max[axis]
            wanted = command.pose[axis]
            if wanted > top or wanted < -top:
                wanted = saturate(wanted, -top, top)
        if pose[axis] != wanted:
            pose[axis] = slew(pose[axis], wanted, params.pose_slew[axis])
            moves = 1
    return moves
