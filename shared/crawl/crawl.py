"""The crawl over obstacles: one leg at a time, three always down, every hind foot on a front foot's foothold.

    measured joints, tilt -> forces, map -> state machine -> pose loop -> load shares -> joint goals

It needs measured joints and attitude. It walks straight ahead along the line it was started on; how a
stage follows a stage is in steps.py.
"""

from ..body.axes import POSE_AXES
from ..body.params import FL, FR, JOINTS, LEGS, LF_BITS, RL, RR, Params
from ..num.filters import fraction
from ..num.fixed import saturate
from ..runtime import Ints, const, hot
from ..sense.legs import Sensing
from .footholds import follow_front_feet, footholds_start
from .goals import absorb_jump, legs_goals, plan_loads
from .map import fit_body, follow_slips, roll_feet
from .pose import hold_pose
from .state import FULL_SHARE_Q12, HISTORY_TICKS, REST, Crawl, Map, Support
from .steps import start_stages, take_stage

_LEAST_WEIGHT_Q12 = const(2867)  # 0.7 and 2.5 of the own weight: what a sum of joint errors may say
_MOST_WEIGHT_Q12 = const(10240)
_EMPTY_Q12 = const(4710)  # 1.15 of the own weight: up to here the robot is empty


@hot
def crawl_start(
    crawl: Crawl, sensing: Sensing, joints: Ints, goals: Ints, roll_brad: int, pitch_brad: int
) -> None:
    """Take over a robot that stands on all four feet as it stands. sensing: as sense_legs left it.

    joints: 12 measured brad within +-32768; goals: the 12 brad sent last. The map begins under the body,
    z = 0 at the mean of the feet; the goals do not jump.
    """
    for joint in range(JOINTS):
        crawl.goals[joint] = goals[joint]
    crawl_reset(crawl)
    start_map(crawl, sensing, joints, roll_brad, pitch_brad)
    start_support(sensing, crawl.support)
    footholds_start(crawl)
    start_stages(crawl)
    plan_loads(crawl)
    for leg in range(LEGS):
        absorb_jump(crawl, leg, 0)


@hot
def crawl_reset(crawl: Crawl) -> None:
    """Put back what a step does not set anew."""
    support = crawl.support
    for leg in range(LEGS):
        support.stance[leg] = 0
        support.force_q12[leg] = 0
    support.payload_q12 = 0
    support.diagonal_offset = 0
    for axis in range(POSE_AXES):
        crawl.path.integral[axis] = 0
        crawl.path.deviation[axis] = 0
    crawl.ground.landings = 0
    crawl.ground.even_landings = 0
    crawl.stage.ahead = 0
    crawl.event.code = 0
    crawl.event.number = 0


@hot
def start_map(crawl: Crawl, sensing: Sensing, joints: Ints, roll_brad: int, pitch_brad: int) -> None:
    """Begin the map under the body, and the body's path where it is. Arguments as crawl_start."""
    map = crawl.map
    path = crawl.path
    level = sensing.level[FR].z + sensing.level[FL].z + sensing.level[RR].z + sensing.level[RL].z >> 2
    for axis in range(POSE_AXES):
        map.body_pose[axis] = 0
    take_tilt(crawl.params, crawl.map, roll_brad, pitch_brad)
    roll_feet(crawl, joints)
    for leg in range(LEGS):
        foot = map.feet[leg]
        foot.x = sensing.level[leg].x << LF_BITS
        foot.y = sensing.level[leg].y << LF_BITS
        foot.z = sensing.level[leg].z - level << LF_BITS
    map.body_pose.z = -level << LF_BITS
    for axis in range(POSE_AXES):
        path.wanted[axis] = map.body_pose[axis]
        path.lagged[axis] = map.body_pose[axis]
        path.commanded[axis] = map.body_pose[axis]


@hot
def start_support(sensing: Sensing, support: Support) -> None:
    """All legs stand and carry what they are felt to."""
    total = 0
    for leg in range(LEGS):
        support.stance[leg] = 1
        support.share_q12[leg] = FULL_SHARE_Q12
        total += sensing.force_q12[leg]
    support.weight_q12 = saturate(total, _LEAST_WEIGHT_Q12, _MOST_WEIGHT_Q12)
    support.weight_q20 = support.weight_q12 << 8


@hot
def take_tilt(params: Params, map: Map, roll_brad: int, pitch_brad: int) -> None:
    """Take the body's measured tilt; in the plane it does not roll."""
    map.body_pose.pitch = pitch_brad << LF_BITS
    map.body_pose.roll = 0
    if params.lateral_q12:
        map.body_pose.roll = roll_brad << LF_BITS


@hot
def crawl_tick(
    crawl: Crawl, sensing: Sensing, measured: Ints, roll_brad: int, pitch_brad: int, ahead_lf: int, joints: Ints
) -> int:
    """Take one tick: 12 measured joints (brad within +-32768) in, 12 goals into ``joints``; return flags.

    sensing: the block of sense_legs after this tick's reading. ahead_lf: how far the command wants to go in
    this tick, lf; 0 or less stops it when the leg in the air stands. Flags are those of reach_foot and
    limit_legs. While it rests its goals stay: moved on towards where it should be, or is, its legs would be held by
    friction and feel no load.
    """
    estimate(crawl, sensing, measured, roll_brad, pitch_brad)
    take_stage(crawl, ahead_lf)
    if crawl.stage.stage != REST:
        hold_pose(crawl)
    plan_loads(crawl)
    return legs_goals(crawl, joints)


@hot
def estimate(crawl: Crawl, sensing: Sensing, measured: Ints, roll_brad: int, pitch_brad: int) -> None:
    """Bring the map, the forces and the weight up to date with what is measured."""
    take_tilt(crawl.params, crawl.map, roll_brad, pitch_brad)
    recentre_map(crawl)
    roll_feet(crawl, measured)
    fit_body(crawl, sensing)
    if crawl.stage.stage != REST:
        follow_slips(crawl)
    follow_front_feet(crawl)
    update_weight(crawl.params, sensing, crawl.support)


@hot
def update_weight(params: Params, sensing: Sensing, support: Support) -> None:
    """Smooth the feet's forces, and from their sum learn the weight carried and how heavy that is."""
    total = 0
    for leg in range(LEGS):
        force = support.force_q12[leg]
        force += fraction(sensing.force_q12[leg] - force, params.crawl.force_q15)
        support.force_q12[leg] = force
        if support.stance[leg]:
            total += force
    gap = (saturate(total, 0, 16383) << 8) - support.weight_q20
    support.weight_q20 += fraction(gap, params.crawl.weight_q15)
    support.weight_q12 = saturate(support.weight_q20 >> 8, _LEAST_WEIGHT_Q12, _MOST_WEIGHT_Q12)
    support.payload_q12 = saturate((support.weight_q12 - _EMPTY_Q12) * 2, 0, 4096)


@hot
def recentre_map(crawl: Crawl) -> int:
    """Move the map's origin to the body's x and z if one is farther than half a leg off; return 1 if it was moved.

    y stays, because its axis is the line that is walked along, until the body is half as far again off it: a new line.
    Farther out the body's next target, which is limited to 32767 lu, would be cut short.

    Exact: the same whole number is taken from everything that is a place, so nothing in the robot's
    motion changes, and the numbers stay within 2^16 lu however far it walks.
    """
    map = crawl.map
    far = crawl.params.leg_length << LF_BITS - 1
    aside = far * 3 >> 1
    x = map.body_pose.x
    y = map.body_pose.y
    z = map.body_pose.z
    if y <= aside and y >= -aside:
        y = 0
        if x <= far and x >= -far and z <= far and z >= -far:
            return 0
    move_origin(crawl, 0, x)
    if y:
        move_origin(crawl, 1, y)
    move_origin(crawl, 2, z)
    return 1


@hot
def move_origin(crawl: Crawl, axis: int, by: int) -> None:
    """Move the map's origin by ``by`` (lf) along ``axis`` (0 x, 1 y, 2 z)."""
    map = crawl.map
    path = crawl.path
    swing = crawl.swing
    map.body_pose[axis] -= by
    for leg in range(LEGS):
        map.feet[leg][axis] -= by
        map.measured[leg][axis] -= by
    for side in range(2):
        queue = crawl.footholds.sides[side]
        for place in range(queue.waiting):
            queue.places[place][axis] -= by
    path.wanted[axis] -= by
    path.from_pose[axis] -= by
    path.to_pose[axis] -= by
    path.lagged[axis] -= by
    path.commanded[axis] -= by
    swing.place[axis] -= by
    swing.target[axis] -= by
    if axis < 2:
        swing.departure[axis] -= by
    else:
        swing.ground -= by
        swing.apex -= by
    if axis == 0:
        for at in range(HISTORY_TICKS):
            crawl.contact.past_x[at] -= by
