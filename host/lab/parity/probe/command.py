"""shared/planner/command.py: any command block, limited and slewed."""


from shared.body.axes import POSE_AXES, TWIST_AXES, Pose, Twist
from shared.gait.table import Gait
from shared.planner import command
from shared.planner.command import Command

from .draw import FLAG, HALF30, INT30, Range
from .draws import ROBOT, TABLE, gait_of
from .probe import Block, Probe
from .row import clear

COMMAND = Block(Command(), (command.COMMAND_SIZE, INT30))
TOLD = Command()
MOST = Twist()
SPEED22, MOST22 = Range(-(1 << 22), 1 << 22), Range(0, 1 << 22)
AXIS = Range(0, 2)
SPEED = Twist()
POSE = Pose()


def _use_gait(values, dice):
    gait: Gait = gait_of(values[0], values[1])
    for axis in range(TWIST_AXES):
        MOST[axis] = gait.speed_max[axis]
    values[1] = MOST


def _posed(values, dice):
    """Now and then the pose is what is commanded, or nearly."""
    told: Command = values[0]
    for axis in range(POSE_AXES):
        POSE[axis] = told.pose[axis]
    if dice.bits(1):
        POSE[dice.below(POSE_AXES)] += 1


def _begin():
    clear(SPEED)
    clear(POSE)


PROBES = (
    Probe(command, "copy_command", (COMMAND, TOLD), watch=(TOLD,)),
    Probe(command, "slew", (HALF30, HALF30, Range(0, (1 << 29) - 1))),
    Probe(command, "slew_speed_axis", (SPEED22, INT30, MOST22, AXIS, MOST22)),
    Probe(command, "slew_speed", (ROBOT, TABLE, COMMAND, AXIS, SPEED), watch=(SPEED,), fit=_use_gait, begin=_begin),
    Probe(command, "is_posed", (COMMAND, POSE), begin=_begin, fit=_posed),
    Probe(command, "slew_pose", (ROBOT, COMMAND, FLAG, POSE), watch=(POSE,), begin=_begin),
)
