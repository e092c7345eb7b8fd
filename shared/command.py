"""The command as the core takes it, limited and slewed: nothing a driver sends acts at once.

A command is one block. Speeds are slewed to what was asked for within the gait's and the robot's
limits, the body pose likewise, so a step of the stick is a ramp of the robot.
"""

from .body import POSE_SIZE
from .fixed import saturate
from .gait import G_VX_MAX
from .params import Params
from .record import field, record, vector
from .runtime import Ints, const, hot
from .steps import SPEED_SIZE


@record
class Command:
    """What a driver wants, limited and slewed by the planner."""

    mode: int = field("", "MODE_...")
    gait: int = field("", "index into gaits.GAITS")
    speed: Ints = vector(3, "", "vx, vy in lf / tick, wz in yaw18 / tick")
    pose: Ints = vector(6, "", "x, y, z in lu; roll, pitch, yaw in brad")
    balance: int = field("", "1: keep the body level by the measured attitude")
    height: int = field("lu", "swing height; 0: the gait's own")



MODE_LIMP = const(0)  # drive nothing: the joints are not held
MODE_STAND = const(1)
MODE_WALK = const(2)
MODE_SIT = const(3)


@hot
def slew(now: int, wanted: int, step: int) -> int:
    """Return ``now`` moved towards ``wanted`` by at most ``step`` (>= 0). Exact, any unit within +-2^29."""
    return now + saturate(wanted - now, -step, step)


@hot
def slew_speed(params: Params, gait: Ints, command: Command, halves: int, speed: Ints) -> int:
    """Move ``speed`` (3 values) one tick towards the command times halves/2; return 1 if it is all 0.

    halves: 0 to stop, 1, or 2 for the whole command, which is first limited to what robot and gait
    allow. Half an odd speed is rounded towards 0, so that left and right mirror.
    """
    still = 1
    for axis in range(SPEED_SIZE):
        top = gait[G_VX_MAX + axis]
        wanted = command.speed[axis]
        if wanted > top or wanted < -top:
            wanted = saturate(wanted, -top, top)
        wanted *= halves
        if wanted < 0:
            wanted = -(-wanted >> 1)
        else:
            wanted >>= 1
        if speed[axis] != wanted:
            speed[axis] = slew(speed[axis], wanted, params.speed_slew[axis])
        if speed[axis]:
            still = 0
    return still


@hot
def slew_pose(params: Params, command: Command, standing: int, pose: Ints) -> int:
    """Move ``pose`` (POSE_SIZE values) one tick towards the command's, level unless ``standing``; return 0."""
    for axis in range(POSE_SIZE):
        wanted = 0
        if standing:
            top = params.pose_max[axis]
            wanted = command.pose[axis]
            if wanted > top or wanted < -top:
                wanted = saturate(wanted, -top, top)
        if pose[axis] != wanted:
            pose[axis] = slew(pose[axis], wanted, params.pose_slew[axis])
    return 0
