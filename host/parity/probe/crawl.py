"""The crawl, shared/crawl*.py and its helpers: any state whose places lie within 32767 lu, and long crawls."""


from shared import (
    contact,
    crawl,
    crawl_even,
    crawl_goals,
    crawl_map,
    crawl_pose,
    crawl_setup,
    crawl_steps,
    footholds,
    handover,
    retreat,
    swing_leg,
)
from shared import crawl_layout as at
from shared.command import Command
from shared.filters import fraction, quintic_q15
from shared.handover import Fade
from shared.params import Params
from shared.runtime import zeros
from shared.sensing import Sensing, keep_sent, sense_legs, sensing_reset
from shared.steps import Steps

from .draw import Range
from .draws import BRAD, LEG, ROBOT
from .probe import Probe
from .robots import PARAMS
from .row import Row

SOURCES = (
    "filters",
    "handover",
    "retreat",
    "footholds",
    "contact",
    "swing_leg",
    "crawl",
    "crawl_even",
    "crawl_goals",
    "crawl_map",
    "crawl_pose",
    "crawl_setup",
    "crawl_steps",
)

CRAWL = crawl.Crawl(PARAMS[0])
STATE = CRAWL.state
SET = CRAWL.settings
LIMBS = Params()
SETTINGS = zeros(at.K_SIZE)
SENSING = Sensing()
JOINTS = zeros(12)
GOALS = zeros(12)
PLACE = Range(-(1 << 23), (1 << 23) - 1)
LU = Range(-32767, 32767)
HIND = Range(2, 3)
SIDE = Range(0, 1)
SWINGS = Range(0, 1)
WAY = Range(-(1 << 20), 1 << 20)
TICKS = Range(0, 1 << 20)

# What of the state is no place: (first, count, range)
_PARTS = (
    (at.C_SHANK, 4, Range(-98304, 98303)),
    (at.C_BODY + 3, 3, Range(-(1 << 22), (1 << 22) - 1)),
    (at.C_STANDS, 4, Range(0, 1)),
    (at.C_SHARE, 4, Range(0, 4096)),
    (at.C_FORCE, 8, Range(-16383, 16383)),
    (at.C_PRINTS, 2, Range(0, 4)),
    (at.C_ON_PRINT, 2, Range(0, 1)),
    (at.C_BODY_TICK, 2, Range(0, 60)),
    (at.C_WARP, 1, Range(-1342208, 1342208)),
    (at.C_WEIGHT, 1, Range(2867, 10240)),
    (at.C_HEAVY, 1, Range(0, 4096)),
    (at.C_GOAL, 12, Range(-32768, 32767)),
    (at.C_CLIPPED, 1, Range(0, 1)),
    (at.C_PHASE, 1, Range(0, 5)),
    (at.C_TICK, 1, Range(0, 150)),
    (at.C_TURN, 2, Range(0, 3)),
    (at.C_PACE, 1, Range(-600000, 600000)),
    (at.C_SPEED, 1, Range(0, 200000)),
    (at.C_MOVE_TICKS, 1, Range(1, 60)),
    (at.C_TRIES, 2, Range(0, 3)),
    (at.C_DROPPED, 1, Range(0, 1)),
    (at.C_LENGTH, 1, Range(0, 32767)),
    (at.C_TARE, 1, Range(-16383, 16383)),
    (at.C_TOUCHED, 1, Range(0, 9)),
    (at.C_PEAK, 1, Range(0, 1)),
    (at.C_PAST_AT, 1, Range(0, 31)),
    (at.C_EVENT, 9, Range(0, 1000)),
    (at.C_WEIGHT_FINE, 1, Range(0, 16383 << 8)),
)


def _soil(values, dice):
    """Fill the state: near the middle of the map every other time, where edges and drops are what is met."""
    bits = 23 if dice.bits(1) else 16
    for place in range(at.C_SIZE):
        STATE[place] = (dice.bits(bits) << 1) - (1 << bits)
    for first, count, spread in _PARTS:
        for place in range(first, first + count):
            STATE[place] = spread.any(dice)
    STATE[at.C_POS + 2] = STATE[at.C_EXPECT] - dice.bits(22)
    for place in range(12):
        SENSING.level[place] = dice.bits(16) - 32768
        JOINTS[place] = dice.bits(14) - 8192
        CRAWL.measured[place] = JOINTS[place]
        CRAWL.pose[place % 6] = dice.bits(14) - 8192
        CRAWL.feet[place] = dice.bits(15) - 16384
        CRAWL.hip_feet[place] = dice.bits(15) - 16384
    for place in range(4):
        SENSING.force_q12[place] = dice.bits(14) - 8192
    CRAWL.point[0] = dice.bits(15) - 16384
    CRAWL.point[1] = dice.bits(15) - 16384
    SET[at.K_PLANAR] = dice.bits(1)


def _stateful(module, name, *arguments):
    return Probe(name, getattr(module, name), arguments, watch=(STATE,), fit=_soil)


class _Walk:
    """A crawl on level ground with joints that follow their goals half way each tick, and now and then on none."""

    def __init__(self):
        self.ticks = 0

    def begin(self):
        sensing_reset(SENSING)
        self.ticks = 0

    def step(self, values, dice):
        if self.ticks % 400 == 0:
            self.start(dice)
        self.ticks += 1
        for joint in range(12):
            CRAWL.measured[joint] = JOINTS[joint]
            JOINTS[joint] += (GOALS[joint] - JOINTS[joint]) // 2 + dice.bits(5) - 16
        SET[at.K_PLANAR] = self.ticks // 400 & 1
        sense_legs(PARAMS[0], JOINTS, values[4], values[5], SENSING)
        for leg in range(4):
            SENSING.force_q12[leg] = 1024 + dice.bits(8) if dice.bits(3) else 2000
            if leg == STATE[at.C_LEG] and STATE[at.C_PHASE] in (at.LIFT, at.MOVE, at.TARE):
                SENSING.force_q12[leg] = dice.bits(6)
        keep_sent(SENSING, GOALS)

    def start(self, dice):
        for leg in range(4):
            JOINTS[leg * 3] = dice.bits(9) - 256
            JOINTS[leg * 3 + 1] = 8000 + dice.bits(10)
            JOINTS[leg * 3 + 2] = -16000 - dice.bits(10)
        for joint in range(12):
            GOALS[joint] = JOINTS[joint]
        sense_legs(PARAMS[0], JOINTS, 0, 0, SENSING)
        crawl.crawl_start(CRAWL, SENSING, JOINTS, 0, GOALS, 0, 0)


WALK = _Walk()
TILT = Range(-600, 600)
STEPS = Steps()
COMMAND = Command()
RETREAT = retreat.Retreat()
RETREAT_ROW = Row(RETREAT)
TOLD = Command()
FADE = Fade()
FADE_ROW = Row(FADE)


def _any_speed(values, dice):
    for axis in range(3):
        COMMAND.speed[axis] = dice.bits(21) - (1 << 20)


def _any_fade(values, dice):
    _soil(values, dice)
    for place in range(len(FADE_ROW)):
        FADE_ROW[place] = dice.bits(16) - 32768
    FADE.left = dice.bits(8) - 1
    FADE.ticks = FADE.left + 1 if dice.bits(1) else 256


def _any_retreat(values, dice):
    """Any command and any way back, often near its end."""
    _any_speed(values, dice)
    for place in range(len(RETREAT_ROW)):
        RETREAT_ROW[place] = dice.bits(24 if dice.bits(1) else 5)


PROBES = (
    Probe("fraction", fraction, (Range(-(1 << 25) + 1, (1 << 25) - 1), Range(0, 32768))),
    Probe("quintic_q15", quintic_q15, (Range(-3, 1 << 29), Range(-3, 1 << 29))),
    Probe("brake_speed", swing_leg.brake_speed, (Range(0, 1 << 29), LU)),
    Probe("crawl_setup", crawl_setup.crawl_setup, (ROBOT, SETTINGS, LIMBS), watch=(SETTINGS, LIMBS), ticks=False),
    Probe("bend_limits", crawl_setup.bend_limits, (ROBOT, SETTINGS, LIMBS), watch=(LIMBS,), ticks=False),
    Probe("accelerations", crawl_setup.accelerations, (SETTINGS, Range(16000, 32767), Range(20, 500)), ticks=False),
    Probe("body_shape", crawl_setup.body_shape, (ROBOT, SETTINGS, Range(16000, 32767)), ticks=False),
    Probe("bent_length", crawl_setup.bent_length, (Range(1, 16384), Range(1, 16383), BRAD), ticks=False),
    _stateful(footholds, "prints_start", ROBOT, STATE),
    Probe("print_line", footholds.print_line, (ROBOT, SIDE)),
    _stateful(footholds, "print_add", STATE, SIDE, at.C_FOOT),
    _stateful(footholds, "print_drop", STATE, SIDE),
    _stateful(footholds, "aim", ROBOT, SET, STATE, LEG),
    _stateful(footholds, "aim_front", ROBOT, SET, STATE, SIDE),
    _stateful(footholds, "aim_hind", ROBOT, SET, STATE, HIND),
    _stateful(footholds, "steps_down", SET, STATE, LEG),
    _stateful(contact, "take_tare", SET, STATE, LEG),
    _stateful(contact, "feel_ground", SET, STATE, LEG),
    _stateful(contact, "corner_lift", SET, STATE, LEG),
    _stateful(contact, "keep_past", STATE),
    _stateful(contact, "feel_riser", SET, STATE, LEG),
    _stateful(swing_leg, "enter", STATE, Range(0, 5)),
    _stateful(swing_leg, "try_again", STATE, PLACE, PLACE),
    _stateful(swing_leg, "lift_foot", SET, STATE),
    _stateful(swing_leg, "start_move", SET, STATE),
    _stateful(swing_leg, "move_foot", STATE),
    _stateful(swing_leg, "fall_speed", SET, STATE, LEG),
    _stateful(swing_leg, "lower_foot", SET, STATE, LEG),
    _stateful(swing_leg, "hang_foot", SET, STATE),
    _stateful(crawl_map, "roll_feet", SET, JOINTS, STATE),
    _stateful(crawl_map, "foot_weight_q8", STATE, LEG),
    _stateful(crawl_map, "fit_heading", SENSING, STATE),
    _stateful(crawl_map, "fit_body", SET, SENSING, STATE),
    _stateful(crawl_map, "follow_slips", SET, STATE),
    _stateful(crawl_map, "shift_points", STATE, at.C_FOOT, 4, PLACE, PLACE, PLACE),
    _stateful(crawl_map, "rebase", SET, STATE),
    _stateful(crawl_pose, "mean_foot", STATE, Range(0, 2)),
    _stateful(crawl_pose, "feet_pitch", SET, STATE),
    _stateful(crawl_pose, "mass_target", SET, STATE, LEG, LU, CRAWL.feet, CRAWL.weights, CRAWL.point),
    _stateful(crawl_pose, "resting_x", SET, STATE),
    _stateful(crawl_pose, "longest_leg", ROBOT, CRAWL.pose, CRAWL.rotation, CRAWL.feet, CRAWL.hip_feet, Range(-1, 3)),
    _stateful(
        crawl_pose,
        "plan_body",
        ROBOT,
        SET,
        STATE,
        CRAWL.point,
        Range(-1, 3),
        CRAWL.pose,
        CRAWL.rotation,
        CRAWL.feet,
        CRAWL.hip_feet,
    ),
    _stateful(crawl_pose, "move_ticks", SET, STATE),
    _stateful(crawl_pose, "move_body", STATE),
    _stateful(crawl_pose, "hold_pose", SET, STATE),
    _stateful(crawl_goals, "warped", STATE, LEG),
    _stateful(crawl_goals, "share_load", SET, STATE, CRAWL.feet, CRAWL.weights, CRAWL.load),
    _stateful(crawl_goals, "take_pose", STATE, SWINGS, CRAWL.pose, CRAWL.rotation),
    _stateful(crawl_goals, "foot_in_body", STATE, LEG, SWINGS, CRAWL.pose, CRAWL.feet),
    _stateful(crawl_goals, "leg_goal", CRAWL, LEG, SWINGS),
    _stateful(crawl_goals, "bridge", CRAWL, LEG, SWINGS),
    _stateful(crawl_goals, "legs_goals", CRAWL, GOALS),
    _stateful(crawl_steps, "tell", STATE, Range(0, 7), PLACE, PLACE),
    _stateful(crawl_steps, "start_machine", CRAWL),
    _stateful(crawl_steps, "machine", CRAWL, WAY),
    _stateful(crawl_steps, "plan_shift", CRAWL),
    _stateful(crawl_steps, "print_x", STATE, HIND),
    _stateful(crawl_steps, "over_foot", CRAWL, LEG, PLACE),
    _stateful(crawl_steps, "shift_to", CRAWL, LEG, LU, Range(-1, 3)),
    _stateful(crawl_steps, "shift_tick", CRAWL, LEG),
    _stateful(crawl_steps, "match_diagonals", CRAWL, LEG),
    _stateful(crawl_steps, "leave_ground", CRAWL, LEG),
    _stateful(crawl_steps, "move_tick", CRAWL, LEG),
    _stateful(crawl_steps, "down_tick", CRAWL, LEG),
    _stateful(crawl_steps, "free_shin", CRAWL, LEG),
    _stateful(crawl_steps, "touch", CRAWL, LEG, PLACE),
    _stateful(crawl_steps, "drop_front", CRAWL, SIDE),
    _stateful(crawl_steps, "drop_hind", CRAWL, HIND),
    _stateful(crawl_steps, "land", CRAWL, LEG),
    _stateful(crawl_even, "count_even", SET, STATE, LEG),
    _stateful(crawl_even, "feet_length", STATE),
    _stateful(crawl_even, "feet_rise", STATE),
    _stateful(crawl_even, "expected_rise", SET, STATE, WAY),
    Probe("off_slope", crawl_even.off_slope, (PLACE, PLACE, Range(1, 16383), Range(-16383, 16383))),
    _stateful(crawl, "measure", CRAWL, JOINTS, 0),
    _stateful(crawl, "weigh", SET, SENSING, STATE),
    _stateful(crawl, "estimate", CRAWL, SENSING, JOINTS, 0, TILT, TILT),
    _stateful(crawl, "crawl_start", CRAWL, SENSING, JOINTS, 0, GOALS, TILT, TILT),
    Probe("retreat_start", retreat.retreat_start, (RETREAT,), watch=(RETREAT,), fit=_any_retreat),
    Probe(
        "retreat_step",
        retreat.retreat_step,
        (ROBOT, COMMAND, Range(-(1 << 23), 1 << 23), Range(0, 1), RETREAT, TOLD),
        watch=(TOLD, RETREAT),
        fit=_any_retreat,
    ),
    Probe("straight_on", handover.straight_on, (ROBOT, COMMAND), fit=_any_speed),
    _stateful(handover, "ground_even", STATE),
    Probe("steps_from_crawl", handover.steps_from_crawl, (ROBOT, STATE, LU, LU, STEPS), watch=(STEPS,), fit=_soil),
    Probe("fade_start", handover.fade_start, (ROBOT, FADE, JOINTS), watch=(FADE,), fit=_any_fade),
    Probe("fade_out", handover.fade_out, (FADE, JOINTS), watch=(FADE, JOINTS), fit=_any_fade),
    Probe(
        "crawl_tick",
        crawl.crawl_tick,
        (CRAWL, SENSING, JOINTS, 0, TILT, TILT, WAY, GOALS),
        watch=(GOALS, STATE),
        begin=WALK.begin,
        fit=WALK.step,
        vectors=10,
    ),
)
