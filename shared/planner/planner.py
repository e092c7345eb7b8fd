"""The planner, once a tick: command and senses in, twelve joint angles and flags out.

    command, senses -> mover -> feet -> balance -> body pose -> 4 x leg -> limits -> wanted -> speed -> joints

States: limp (nothing is driven), rising, standing, walking, sitting (going down), seated, folding (on its belly). A
command names a mode, and the planner goes there through the states between: the robot never walks before it has stood
up, and never sits down in mid-stride.

Its parts: states (which state next), mover_choice and movers (a table, the trot or the crawl walks), senses, for the
movers follow (the command) and pose (body and legs), status (what the planner reports), state (all it remembers).
"""

from ..body.params import Params
from ..gait.table import MOVER_TROT
from ..runtime import hot
from ..sense.legs import keep_sent
from ..sense.sensed import Sensed
from .command import Command
from .goals import follow_goals
from .mover_choice import choose_mover
from .movers import change_mover, tick_mover
from .posture import posture_step
from .senses import take_senses, update_odometry, update_sensing
from .state import PlannerState
from .states import choose_state, end_move, follow_joints, reset_motion
from .status import FOLDING, LIMP, RISING, SEATED, SITTING
from .weight import stays_lifted, watch_weight


class Planner(PlannerState):
    """The control core of one robot at one rate.

    ``Planner(params)`` allocates all it needs; ``tick`` allocates nothing. After a tick read ``joints`` (12 brad, the
    goals to send), ``leg_flags`` (4), ``status``, ``reached`` (the planned feet, lu from the hips; the crawl has its
    own). Raises ValueError if a gait can't fit the robot.
    """

    def __init__(self, params: Params, more: tuple = ()):
        super().__init__(params, more)
        reset_motion(self)

    def tick(self, command: Command, sensed: Sensed) -> int:
        """Take a command and what is sensed, plan one tick; return the flags.

        Any 30-bit value in either block is tolerated: speeds and poses are limited, an unknown mode or gait sets
        BAD_COMMAND. Intermediates are those of the functions called.
        """
        return plan(self, command, sensed)


@hot
def plan(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Do one tick of the planner; return its flags."""
    status = planner.status
    status.flags = 0
    take_senses(planner, sensed)
    choose_state(planner, command, planner.sensed)
    update_sensing(planner)
    lifted = stays_lifted(planner, command.mode)
    state = status.state
    if state == LIMP:
        follow_joints(planner, planner.sensed)
    elif state == RISING or state == SITTING or state == FOLDING:
        if posture_step(planner.move, planner.goal) == 0:
            end_move(planner)
    elif state != SEATED and lifted == 0:
        move(planner, command, planner.sensed)
    if update_odometry(planner):
        watch_weight(planner)
    follow_goals(planner.params, planner.goal, planner.joints)
    if planner.sensing.known:
        keep_sent(planner.sensing, planner.joints)
    return status.flags


@hot
def move(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Do one tick of standing or walking by the mover whose turn it is."""
    change_mover(planner, choose_mover(planner, command, sensed))
    reason = tick_mover(planner, command, sensed)
    if reason:
        planner.status.reason = reason
        change_mover(planner, MOVER_TROT)
