"""Standing and walking by a gait: begin and end a walk, exchange gaits between cycles, move and place the feet.

    command -> wanted gait -> slewed speed -> gait clock -> feet
"""

from ..body.balance import balance_gains
from ..body.pose import POSE_SIZE
from ..gait.gaits import GAIT_ADAPTIVE, GAIT_CLIMB
from ..gait.steps import SPEED_SIZE, body_advance, lift_at_once, move_feet, place_feet, start_swings, steps_at_rest
from ..gait.table import gait_clock
from ..num.fixed import saturate
from ..runtime import const, hot
from ..trot.navigate import drive_as_told
from ..trot.trot import begin_segment, drive_speed, learn_centre, sway_body, trot_start
from .command import MODE_WALK, Command, slew_pose, slew_speed
from .state import PlannerState
from .status import BAD_COMMAND, POSE_HELD, STANDING, WALKING

_WAIT_S = const(6)  # longer than a body's length takes at 0.05 m/s


@hot
def step_gait(planner: PlannerState, command: Command) -> int:
    """Move the feet by one tick of the gait, and start or end walking where that is safe; return 0.

    The first cycle of a table gait is walked at half speed: all feet start at rest, in the middle of their
    way, and the last to swing would else be left a whole stride behind. The adaptive one starts slowly anyway.
    """
    status = planner.status
    wanted = crawl_waits(planner, wanted_gait(planner, command))
    if status.state == STANDING:
        use_gait(planner, wanted)
        status.cycles = 0
    fits = limit_to_both(planner, wanted)
    halves = 0
    if command.mode == MODE_WALK and status.fallen == 0:
        halves = 1
        if status.cycles or status.gait == GAIT_ADAPTIVE:
            halves = 2
    still = slew_speed(planner.params, planner.top, command, halves, planner.speed)
    held = 0
    if status.beyond or status.holds:
        held = hold_back(planner, command)
    if held == 0:
        slew_pose(planner.params, command, 1, planner.pose)
    if status.state == STANDING:
        if still:
            place_feet(planner.params, planner.gait, planner.steps, planner.speed, 0, planner.feet)
            status.swinging = 0
            if status.gait == GAIT_ADAPTIVE:
                sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
            return 0
        status.state = WALKING
        trot_start(planner.params, planner.walk)
    walk_on(planner, command.height, still)
    if gait_clock(planner.gait, planner.clock):
        status.cycles = 1
        if still and steps_at_rest(planner.params, planner.steps):
            status.state = STANDING
        elif fits:
            use_gait(planner, wanted)
        else:
            use_gait(planner, status.gait)
    return 0


@hot
def hold_back(planner: PlannerState, command: Command) -> int:
    """Take the body's pose a step back where a standing leg is beyond its reach; return 1 if it is held there.

    It is held until another pose is commanded (POSE_HELD). A leg in the air only cuts its own swing short.
    """
    status = planner.status
    pose = planner.pose
    posed = 0
    for axis in range(POSE_SIZE):
        if pose[axis]:
            posed = 1
        if status.held[axis] != command.pose[axis]:
            status.held[axis] = command.pose[axis]
            status.holds = 0
    if status.beyond and posed:
        status.holds = 1
        slew_pose(planner.params, command, 0, planner.pose)
    if status.holds:
        status.flags |= POSE_HELD
    return status.holds


@hot
def walk_on(planner: PlannerState, height_lu: int, still: int) -> int:
    """Move and place all feet for one tick of the gait's clock; return the legs in swing, bits.

    height: lift of a swing, lu; 0 or less: the gait's own. still: 1 while the commanded speed is 0.
    """
    status = planner.status
    params = planner.params
    trot = planner.trot
    clock = planner.clock
    own = 0
    if height_lu <= 0:
        height_lu = status.height
    if status.gait == GAIT_ADAPTIVE:
        own = 1
        height_lu = saturate(height_lu, 0, 32767) + trot.lift
    height_lu = saturate(height_lu, 0, -params.sit_z)
    if own and still == 0:
        drive_speed(planner.params, planner.walk, planner.speed, planner.drive)
    else:
        drive_as_told(planner.speed, planner.drive)
    if clock.tick == 0:
        if own:
            begin_segment(planner.params, planner.walk, planner.gait, planner.clock, planner.speed, planner.drive)
        start_swings(planner.gait, planner.clock, planner.steps)
        if own:
            lift_at_once(planner.steps, height_lu)
    move_feet(planner.steps, planner.drive, body_advance(planner.gait, planner.clock))
    status.swinging = place_feet(planner.params, planner.gait, planner.steps, planner.drive, height_lu, planner.feet)
    if own:
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 1)
        learn_centre(planner.params, planner.walk, planner.clock)
    return status.swinging


@hot
def limit_to_both(planner: PlannerState, wanted: int) -> int:
    """Take as the fastest command what the present gait and the ``wanted`` one both allow.

    Returns 1 if the present speed is within that of the wanted gait: a faster walk would step too far in it.
    """
    gait = planner.gait
    other = planner.gaits[wanted]
    status = planner.status
    speed = planner.speed
    top = planner.top
    fits = 1
    for axis in range(SPEED_SIZE):
        most = other.speed_max[axis]
        if speed[axis] > most or speed[axis] < -most:
            fits = 0
        if gait.speed_max[axis] < most:
            most = gait.speed_max[axis]
        top[axis] = most
    if status.gait == GAIT_ADAPTIVE:
        start_slowly(planner)
    return fits


@hot
def start_slowly(planner: PlannerState) -> int:
    """Limit ``top`` to what the adaptive trot may do so soon after its start, turning in proportion; return 0.

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
def wanted_gait(planner: PlannerState, command: Command) -> int:
    """Return the index of the commanded gait, or of the present one if there is no such gait."""
    status = planner.status
    gait = command.gait
    if gait < 0 or gait >= status.gaits:
        status.flags |= BAD_COMMAND
        return status.gait
    return gait


@hot
def crawl_waits(planner: PlannerState, wanted: int) -> int:
    """Return the gait to go on with: ``wanted``, or the adaptive trot while it feels for where the crawl may begin.

    A walking robot trots on adaptively until its feet stand level or it was held up and has backed off
    (exchange.py), at most 6 s: where they are not level for so long is a slope. Without measured joints it
    does not wait.
    """
    status = planner.status
    params = planner.params
    sensing = planner.sensing
    if wanted != GAIT_CLIMB or status.state != WALKING or status.gait == GAIT_CLIMB:
        status.waited = 0
        return wanted
    status.waited = saturate(status.waited + 1, 0, 0xFFFF)
    if status.waited > params.rate_hz * _WAIT_S or (status.gait == GAIT_ADAPTIVE and sensing.known == 0):
        return wanted
    return GAIT_ADAPTIVE


@hot
def use_gait(planner: PlannerState, gait: int) -> int:
    """Walk ``gait`` from its first segment on; only between cycles, when all feet stand. Returns 0."""
    status = planner.status
    params = planner.params
    clock = planner.clock
    clock.tick = 0
    clock.made_q10 = 0
    clock.segment = 0
    status.gait = gait
    planner.gait = planner.gaits[gait]
    if gait == GAIT_ADAPTIVE:
        balance_gains(planner.params, 1, planner.balance)
    else:
        balance_gains(planner.params, 0, planner.balance)
    g = planner.gait
    status.height = (g.height_mm << params.length_shift) // 1000
    return 0
