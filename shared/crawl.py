"""The crawl over obstacles: one leg at a time, three always down, every hind foot in a front foot's print.

    measured joints, tilt -> forces, map -> state machine -> pose loop -> load shares -> joint goals

It needs measured joints and attitude. It walks straight ahead along the line it was started on; how a
phase follows a phase is in crawl_steps.py.
"""

from .body import POSE_PITCH, POSE_ROLL, POSE_SIZE
from .crawl_goals import bridge, legs_goals, share_load
from .crawl_layout import (
    C_BODY,
    C_CMD,
    C_FOOT,
    C_FORCE,
    C_GOAL,
    C_HEAVY,
    C_LAGGED,
    C_REF,
    C_SHARE,
    C_SIZE,
    C_STANDS,
    C_WEIGHT,
    C_WEIGHT_FINE,
    K_FORCE,
    K_PLANAR,
    K_WEIGHT,
)
from .crawl_map import fit_body, follow_slips, rebase, roll_feet
from .crawl_pose import hold_pose
from .crawl_state import Crawl
from .crawl_steps import machine, start_machine
from .filters import fraction
from .fixed import saturate
from .footholds import prints_start
from .params import JOINTS, LEGS, LF_BITS
from .runtime import Ints, const, hot
from .sensing import Sensing

_OWN_Q12 = const(4096)
_LEAST_WEIGHT_Q12 = const(2867)  # 0.7 and 2.5 of the own weight: what a sum of joint errors may say
_MOST_WEIGHT_Q12 = const(10240)
_EMPTY_Q12 = const(4710)  # 1.15 of the own weight: up to here the robot is empty


@hot
def crawl_start(
    crawl: Crawl, sensing: Sensing, joints, first: int, goals: Ints, roll_brad: int, pitch_brad: int
) -> int:
    """Take over a robot that stands on all four feet as it stands; return 0. sensing: as sense_legs left it.

    joints: 12 measured brad from ``first`` on; goals: the 12 brad sent last. The map begins under the body,
    z = 0 at the mean of the feet; the goals do not jump.
    """
    c = crawl.state
    k = crawl.settings
    for at in range(C_SIZE):
        c[at] = 0
    c[C_BODY + POSE_PITCH] = pitch_brad << LF_BITS
    measure(crawl, joints, first)
    roll_feet(crawl.settings, crawl.measured, crawl.state)
    height = sensing.level[2] + sensing.level[5] + sensing.level[8] + sensing.level[11] >> 2
    total = 0
    for leg in range(LEGS):
        for axis in range(3):
            c[C_FOOT + leg * 3 + axis] = sensing.level[leg * 3 + axis] << LF_BITS
        c[C_FOOT + leg * 3 + 2] -= height << LF_BITS
        c[C_STANDS + leg] = 1
        c[C_SHARE + leg] = _OWN_Q12
        total += sensing.force_q12[leg]
    c[C_WEIGHT] = saturate(total, _LEAST_WEIGHT_Q12, _MOST_WEIGHT_Q12)
    c[C_WEIGHT_FINE] = c[C_WEIGHT] << 8
    c[C_BODY + 2] = -height << LF_BITS
    if k[K_PLANAR] == 0:
        c[C_BODY + POSE_ROLL] = roll_brad << LF_BITS
    for axis in range(POSE_SIZE):
        c[C_REF + axis] = c[C_BODY + axis]
        c[C_LAGGED + axis] = c[C_BODY + axis]
        c[C_CMD + axis] = c[C_BODY + axis]
    for joint in range(JOINTS):
        c[C_GOAL + joint] = goals[joint]
    prints_start(crawl.limbs, crawl.state)
    start_machine(crawl)
    share_load(crawl.settings, crawl.state, crawl.feet, crawl.weights, crawl.load)
    for leg in range(LEGS):
        bridge(crawl, leg, 0)
    return 0


@hot
def measure(crawl: Crawl, joints: Ints, first: int) -> int:
    """Copy 12 measured joints (brad) from ``joints[first]`` on, limited to +-32768; return 0."""
    m = crawl.measured
    for joint in range(JOINTS):
        m[joint] = saturate(joints[first + joint], -32768, 32767)
    return 0


@hot
def crawl_tick(crawl: Crawl, sensing, sensed, first: int, roll_brad: int, pitch_brad: int, way_lf: int, joints) -> int:
    """Take one tick: 12 measured joints from ``sensed[first]`` on, in; 12 goals into ``joints``; return flags.

    sensing: the block of sense_legs after this tick's reading. way_lf: how far the command wants to go in
    this tick, lf; 0 or less stops it when the leg in the air stands. Flags are those of reach_foot and
    limit_joints.
    """
    estimate(crawl, sensing, sensed, first, roll_brad, pitch_brad)
    machine(crawl, way_lf)
    hold_pose(crawl.settings, crawl.state)
    share_load(crawl.settings, crawl.state, crawl.feet, crawl.weights, crawl.load)
    return legs_goals(crawl, joints)


@hot
def estimate(crawl: Crawl, sensing, sensed, first: int, roll_brad: int, pitch_brad: int) -> int:
    """Bring the map, the forces and the weight up to date with what is measured; return 0."""
    k = crawl.settings
    c = crawl.state
    c[C_BODY + POSE_PITCH] = pitch_brad << LF_BITS
    c[C_BODY + POSE_ROLL] = 0
    if k[K_PLANAR] == 0:
        c[C_BODY + POSE_ROLL] = roll_brad << LF_BITS
    measure(crawl, sensed, first)
    rebase(crawl.settings, crawl.state)
    roll_feet(crawl.settings, crawl.measured, crawl.state)
    fit_body(crawl.settings, sensing, crawl.state)
    follow_slips(crawl.settings, crawl.state)
    weigh(crawl.settings, sensing, crawl.state)
    return 0


@hot
def weigh(settings: Ints, sensing: Sensing, state: Ints) -> int:
    """Smooth the feet's forces, and from their sum learn the weight carried and how heavy that is; return 0."""
    total = 0
    for leg in range(LEGS):
        state[C_FORCE + leg] += fraction(sensing.force_q12[leg] - state[C_FORCE + leg], settings[K_FORCE])
        if state[C_STANDS + leg]:
            total += state[C_FORCE + leg]
    gap = (saturate(total, 0, 16383) << 8) - state[C_WEIGHT_FINE]
    state[C_WEIGHT_FINE] += fraction(gap, settings[K_WEIGHT])
    state[C_WEIGHT] = saturate(state[C_WEIGHT_FINE] >> 8, _LEAST_WEIGHT_Q12, _MOST_WEIGHT_Q12)
    state[C_HEAVY] = saturate((saturate(state[C_WEIGHT], _OWN_Q12, _MOST_WEIGHT_Q12) - _EMPTY_Q12) * 2, 0, 4096)
    return 0
