"""Which state follows which: stand up before walking, sit down from a stand, lie limp, give up when tilted too far.

    limp -> rising -> standing -> walking -> standing -> sitting -> seated -> rising
    limp -> folding -> seated

A move between stand and seat goes from the joints' present goals to the next posture, all legs at once. A robot that
lies on its belly, its legs anywhere, first folds them at its sides, where they lift nothing, then puts its feet under
it.
"""

from ..body.axes import POSE_AXES
from ..body.balance import balance_reset
from ..body.params import CALF, JOINTS, LEGS, THIGH
from ..gait.steps import place_feet, steps_reset
from ..gait.table import MOVER_TABLE
from ..runtime import hot
from ..sense.legs import sensing_reset
from ..sense.sensed import PITCH, ROLL, Sensed
from ..trot.trot import trot_start
from .command import MODE_FOLD, MODE_LIMP, MODE_SIT, MODE_STAND, Command
from .goals import joints_near
from .pose import solve_legs
from .posture import posture_start, posture_step
from .state import PlannerState
from .status import (
    BAD_COMMAND,
    CARRIES_NOT,
    FALLEN,
    FOLDING,
    LIMP,
    NO_JOINTS,
    NOT_DRIVEN,
    RISING,
    SEATED,
    SITTING,
    STANDING,
    WALKING,
)


@hot
def choose_state(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Go from the present state towards the commanded mode."""
    status = planner.status
    mode = command.mode
    if mode < MODE_LIMP or mode > MODE_FOLD:
        status.flags |= BAD_COMMAND
        mode = MODE_STAND
    state = status.state
    if watch_tilt(planner, sensed, mode):
        status.flags |= FALLEN
        if mode != MODE_LIMP:
            mode = MODE_SIT
            if state == WALKING:
                begin_move(planner, sensed, SITTING)
    if mode == MODE_LIMP:
        status.state = LIMP
        status.swinging = 0
    elif mode == MODE_SIT or mode == MODE_FOLD:
        if state == STANDING or state == RISING:
            begin_move(planner, sensed, SITTING)
        elif state == LIMP and mode == MODE_FOLD:
            begin_move(planner, sensed, FOLDING)
    elif state == LIMP or state == SEATED or state == SITTING:
        begin_move(planner, sensed, RISING)


@hot
def watch_tilt(planner: PlannerState, sensed: Sensed, mode: int) -> int:
    """Return 1 if the robot has fallen: tilted too far for too long, and not commanded to sit or to be limp since.

    The tilt is watched while the robot stands or walks and its attitude is known.
    """
    status = planner.status
    if mode == MODE_LIMP or mode == MODE_SIT:
        status.fallen = 0
    most = planner.params.tilt_max
    roll = sensed.tilt[ROLL]
    pitch = sensed.tilt[PITCH]
    if sensed.valid.tilt == 0 or (status.state != STANDING and status.state != WALKING):
        status.tilted = 0
    elif roll > most or roll < -most or pitch > most or pitch < -most:
        status.tilted += 1
    else:
        status.tilted = 0
    if status.tilted > planner.params.tilt_ticks:
        status.fallen = 1
        status.tilted = 0
    return status.fallen


@hot
def begin_move(planner: PlannerState, sensed: Sensed, state: int) -> None:
    """Start RISING to the rest stance, SITTING down or FOLDING the legs, from the last goals.

    A limp robot's goals follow its joints. While these are unknown, or the goals have not caught up with them, it stays
    limp (NO_JOINTS), because its pose is unknown.
    """
    status = planner.status
    known = 0
    if sensed.valid.joints:
        known = joints_near(planner.params, sensed.joints, planner.joints)
    if status.state == LIMP and known == 0:
        status.flags |= NO_JOINTS
        return
    status.state = state
    status.swinging = 0
    reset_motion(planner)
    if state == SITTING:
        seat_feet(planner)
    solve_legs(planner, planner.goal)
    if state == FOLDING:
        fold_at_sides(planner)
    posture_start(planner.params, planner.move, planner.joints, planner.goal)


@hot
def end_move(planner: PlannerState) -> None:
    """Go to the state that follows the finished move. Legs folded at the sides are put under the robot first."""
    status = planner.status
    if status.state != FOLDING:
        status.state += 1
    elif status.folded:
        status.state = SEATED
    else:
        begin_move(planner, planner.sensed, SITTING)
        posture_step(planner.move, planner.goal)
        status.state = FOLDING
        status.folded = 1


@hot
def fold_at_sides(planner: PlannerState) -> None:
    """Set the goals to all legs folded at the sides."""
    for leg in range(LEGS):
        lies = planner.params.legs[leg].folded
        planner.goal[leg * 3] = lies.hip
        planner.goal[leg * 3 + THIGH] = lies.thigh
        planner.goal[leg * 3 + CALF] = lies.calf


@hot
def reset_motion(planner: PlannerState) -> None:
    """Forget all motion: feet at rest under a level body, speed 0."""
    planner.speed.vx = 0
    planner.speed.vy = 0
    planner.speed.wz = 0
    for axis in range(POSE_AXES):
        planner.pose[axis] = 0
        planner.balanced_pose[axis] = 0
    planner.fade.left = 0
    status = planner.status
    status.mover = MOVER_TABLE
    status.backing_off = 0
    status.pose_held = 0
    status.folded = 0
    status.pose_moves = 0
    status.carries_weight = CARRIES_NOT
    status.feet_load_q12 = 0
    balance_reset(planner.balance)
    steps_reset(planner.params, planner.steps)
    sensing_reset(planner.sensing)
    trot_start(planner.params, planner.trot)
    place_feet(planner.params, planner.gait, planner.steps, planner.speed, 0, planner.feet)


@hot
def seat_feet(planner: PlannerState) -> None:
    """Raise all planned feet to the seat's height under the hips."""
    for leg in range(LEGS):
        planner.feet.legs[leg].z = planner.params.legs[leg].hip.z + planner.params.sit_z


@hot
def follow_joints(planner: PlannerState, sensed: Sensed) -> None:
    """Limp: set the goals to the joints as measured; nothing holds them."""
    planner.status.flags |= NOT_DRIVEN
    if sensed.valid.joints:
        for joint in range(JOINTS):
            planner.goal[joint] = sensed.joints[joint]
