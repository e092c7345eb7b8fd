"""The trot mover: what is sensed goes to the trot (shared/trot), whose table, speed, sway and footholds follow it.

    senses -> legs, ground, motion;  command -> slewed speed -> corrected speed -> gait clock -> feet -> body and legs
"""

from ..gait.steps import lift_at_once, start_swings
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.sensed import Sensed
from ..trot.navigate import drive_as_told
from ..trot.trot import begin_segment, drive_speed, learn_centre, sway_body, trot_start
from .command import Command
from .pose import pose_legs
from .senses import feel
from .state import PlannerState
from .status import STANDING
from .steps import follow_command, lift_height, limit_to_both, next_cycle, stands, step_feet, wanted_gait


@hot
def walk_trot(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of standing or walking by the trot; return 0.

    In its first tick after standing up, or after a table gait that stood, the trot does not feel yet.
    """
    status = planner.status
    trot = planner.trot
    stood = 0
    feels = 1
    if status.state == STANDING:
        stood = 1
        feels = trot.active
    if feels:
        feel(planner, sensed)
    wanted = wanted_gait(planner, command)
    fits = limit_to_both(planner, wanted)
    start_slowly(planner)
    still = follow_command(planner, command, 2)
    if stands(planner, still):
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
    else:
        if stood:
            trot_start(planner.params, planner.walk)
        step_trot(planner, command.height, still)
        next_cycle(planner, wanted, fits, still)
    pose_legs(planner, command, sensed, feels)
    trot.active = 1
    return 0


@hot
def start_slowly(planner: PlannerState) -> int:
    """Limit ``top`` to what the trot may do so soon after its start, turning in proportion; return 0.

    Intermediates: 2^18 turned down to 12 bits times 2^16.
    """
    params = planner.params
    trot = planner.trot
    top = planner.top
    fastest = trot.fastest
    for axis in range(2):
        if top[axis] > fastest:
            top[axis] = fastest
    share_q10 = saturate((fastest << 10) // params.speed_max[0], 1, 1024)
    turn = (params.speed_max[2] * share_q10 >> 10) + 1
    if top[2] > turn:
        top[2] = turn
    return 0


@hot
def step_trot(planner: PlannerState, height_lu: int, still: int) -> int:
    """Move and place all feet for one tick of the trot; return the legs in swing, bits.

    height: lift of a swing, lu; 0 or less: the gait's own. still: 1 while the commanded speed is 0.
    """
    status = planner.status
    trot = planner.trot
    clock = planner.clock
    height_lu = lift_height(planner, height_lu, trot.lift)
    if still:
        drive_as_told(planner.speed, planner.drive)
    else:
        drive_speed(planner.params, planner.walk, planner.speed, planner.drive)
    if clock.tick == 0:
        begin_segment(planner.params, planner.walk, planner.gait, planner.clock, planner.speed, planner.drive)
        start_swings(planner.gait, planner.clock, planner.steps)
        lift_at_once(planner.steps, height_lu)
    step_feet(planner, height_lu)
    sway_body(planner.params, planner.walk, planner.gait, planner.clock, 1)
    learn_centre(planner.params, planner.walk, planner.clock)
    return status.swinging
