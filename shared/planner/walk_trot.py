"""The trot's mover: hands command and senses to the trot (shared/trot), its goals and feet to the planner."""

from ..body.axes import POSE_AXES
from ..body.legs import legs_forward
from ..body.params import LEGS, LF_BITS
from ..gait.steps import steps_reset
from ..gait.table import MOVER_CRAWL, MOVER_TROT
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.sensed import Sensed
from ..trot.feedforward import solve
from ..trot.state import trot_reset
from ..trot.trot import trot_done, trot_tick
from .command import Command
from .follow import follow_command, limit_to_both, use_gait, wanted_gait
from .handover import crawl_can_follow, fade_start
from .state import PlannerState
from .status import BLIND, NO_ATTITUDE, STANDING, WALKING


@hot
def start_trot(planner: PlannerState) -> None:
    """Begin with the feet where the goals sent last put them."""
    trot_reset(planner.params, planner.trot)
    legs_forward(planner.params, planner.joints, planner.trot.work.waves, planner.trot.feet)
    for leg in range(LEGS):
        foot = planner.trot.feet.legs[leg]
        foot.x <<= LF_BITS
        foot.y <<= LF_BITS
        foot.z <<= LF_BITS
    for axis in range(POSE_AXES):
        planner.trot.last_pose[axis] = planner.pose[axis]
    solve(planner.params, planner.trot)


@hot
def walk_trot(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Do one tick of standing or walking by the trot.

    Without measured joints, tilt or rates it follows the command without feedback (BLIND).
    """
    status = planner.status
    trot_command = planner.trot.command
    still = follow_trot(planner, command)
    if status.state == STANDING and still == 0:
        status.state = WALKING
    trot_command.moving = 0
    if status.state == WALKING:
        trot_command.moving = 1
    trot_command.balance = command.balance
    trot_command.height = command.height
    flags = trot_tick(planner.params, planner.trot, sensed, planner.speed, planner.pose, planner.goal)
    status.flags |= flags
    status.out_of_reach = 0
    if trot_command.moving == 0 and flags:
        status.out_of_reach = 1
    if trot_command.moving and still and trot_done(planner.trot):
        status.state = STANDING
    if planner.trot.state.known == 0:
        status.flags |= BLIND
        if command.balance:
            status.flags |= NO_ATTITUDE
    status.swinging = planner.trot.state.swinging
    status.margin = 0


@hot
def follow_trot(planner: PlannerState, command: Command) -> int:
    """Slew speed and pose towards the command, limited while swings are high; return 1 if the speed is 0.

    If the command is for another mover, the trot comes to a stand.
    """
    wanted = wanted_gait(planner, command)
    limit_to_both(planner, wanted)
    if planner.trot.state.high_left:
        most = planner.params.trot.high_speed
        planner.top_speed.vx = saturate(planner.top_speed.vx, 0, most)
        planner.top_speed.vy = saturate(planner.top_speed.vy, 0, most)
    halves = 0
    gait = planner.gaits[wanted]
    if gait.mover == MOVER_TROT or (gait.mover == MOVER_CRAWL and crawl_can_follow(planner.params, command) == 0):
        halves = 2
        if planner.status.gait != wanted:
            use_gait(planner, wanted)
    return follow_command(planner, command, halves)


@hot
def stop_trot(planner: PlannerState) -> None:
    """End the trot, which stands; another mover goes on from its goals."""
    planner.speed.vx = 0
    planner.speed.vy = 0
    planner.speed.wz = 0
    steps_reset(planner.params, planner.steps)
    fade_start(planner.params, planner.fade, planner.joints)
    planner.status.cycles = 0
