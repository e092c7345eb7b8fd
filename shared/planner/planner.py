"""The whole robot, once a tick: command and senses in, twelve joint angles and flags out.

    command -> slew -> gait clock -> feet -> balance -> body pose -> 4 x leg -> limits -> wanted -> speed -> joints

States: limp (nothing is driven), rising, standing, walking, sitting (going down), seated. A
command names a mode, and the planner goes there through the states between: nobody walks who has
not stood up first, and nobody sits down in mid-stride.

Its parts: states (which state next), senses and steps (the feet), pose (body and legs), exchange (the crawl instead
of all that), status (states, flags and what the planner tells), state (all it remembers).
"""

from ..body.leg import limit_joints
from ..body.params import LEGS, Params
from ..gait.gaits import GAIT_ADAPTIVE
from ..runtime import hot
from ..sense.legs import keep_sent
from ..sense.sensed import Sensed
from ..trot.trot import pose_body, raise_body, share_weight
from .command import Command
from .exchange import climb, climbs
from .goals import follow_goals
from .handover import fade_out
from .pose import level, solve_legs
from .posture import posture_step
from .senses import feel, relax, take_senses
from .state import PlannerState
from .states import choose_state, follow_joints, settle
from .status import CLIMB_BACK, LIMP, RISING, SEATED, SITTING
from .steps import step_gait


class Planner(PlannerState):
    """The control core of one robot at one rate.

    ``Planner(params)`` allocates all it needs; ``tick`` allocates nothing. After a tick read
    ``joints`` (12 brad, what is to be sent), ``leg_flags`` (4), ``status``, ``feet`` (12 lu, planned, in the
    base frame), ``reached`` (12 lu from the hips). Raises ValueError if a gait can't fit the robot.
    """

    def __init__(self, params: Params):
        super().__init__(params)
        settle(self)

    def tick(self, command: Command, sensed: Sensed) -> int:
        """Take a command and what is sensed, plan one tick; return the flags.

        Any 30-bit value in either block is survived: speeds and poses are limited, an unknown mode or
        gait sets BAD_COMMAND. Intermediates are those of the functions called.
        """
        return plan(self, command, sensed)


@hot
def plan(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of the planner; returns its flags."""
    status = planner.status
    sensing = planner.sensing
    status.flags = 0
    take_senses(planner, sensed)
    choose_state(planner, command, planner.sensed)
    state = status.state
    if state == LIMP:
        follow_joints(planner, planner.sensed)
    elif state == RISING or state == SITTING:
        if posture_step(planner.move, planner.goal) == 0:
            status.state = state + 1
    elif state != SEATED:
        if climbs(planner, command, planner.sensed):
            climb(planner, command, planner.sensed)
        elif status.climb == CLIMB_BACK:
            gait_tick(planner, planner.back, planner.sensed)
        else:
            gait_tick(planner, command, planner.sensed)
    follow_goals(planner.params, planner.goal, planner.joints)
    if sensing.known:
        keep_sent(planner.sensing, planner.joints)
    return status.flags


@hot
def gait_tick(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of standing or walking by a gait's table or the adaptive trot; return 0."""
    status = planner.status
    own = 0
    if status.gait == GAIT_ADAPTIVE:
        own = 1
        feel(planner, sensed)
    step_gait(planner, command)
    level(planner, command, sensed)
    active = raise_body(planner.params, planner.walk, own)
    status.margin = share_weight(planner.params, planner.walk, planner.reached, status.swinging, own)
    if active:
        correction = planner.balance.correction
        pose_body(planner.params, planner.walk, correction.roll, correction.pitch, planner.posed)
    status.flags |= solve_legs(planner, planner.goal)
    fade = planner.fade
    if fade.left:
        fade_out(planner.fade, planner.goal)
        for leg in range(LEGS):
            limit_joints(planner.params, leg, planner.goal)
    if own == 0:
        relax(planner)
    return 0
