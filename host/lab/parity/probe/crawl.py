"""The crawl, shared/crawl*.py and its helpers: any state whose places lie within 32767 lu, and long crawls."""


from shared.body.params import Params
from shared.crawl import contact, crawl, footholds
from shared.crawl import goals as crawl_goals
from shared.crawl import ground as crawl_ground
from shared.crawl import map as crawl_map
from shared.crawl import pose as crawl_pose
from shared.crawl import steps as crawl_steps
from shared.crawl import swing as swing_leg
from shared.crawl.state import HANG, HISTORY_TICKS, LIFT, MOST_FOOTHOLDS, SWING
from shared.gait.steps import Steps
from shared.num import filters
from shared.planner import handover, retreat
from shared.planner.command import Command
from shared.planner.handover import Fade
from shared.record import copy
from shared.runtime import zeros
from shared.sense.legs import MeasuredFeet, Sensing, keep_sent, sense_legs, sensing_reset

from .draw import BRAD, FLAG, FORCE, LEG, UNIT, Range
from .draws import ROBOT
from .probe import Probe, probe_with
from .robots import PARAMS
from .row import Row

OWN = Params()
copy(PARAMS[0], OWN)
LATERAL_Q12 = OWN.lateral_q12
CRAWL = crawl.Crawl(OWN)
STAGE = CRAWL.stage
MAP = CRAWL.map
SUPPORT = CRAWL.support
FOOTHOLDS = CRAWL.footholds
PATH = CRAWL.path
FOOT = CRAWL.swing
CONTACT = CRAWL.contact
GROUND = CRAWL.ground
EVENT = CRAWL.event
STATE = (STAGE, MAP, SUPPORT, FOOTHOLDS, PATH, FOOT, CONTACT, GROUND, EVENT, CRAWL.goals, CRAWL.jumps)
SENSING = Sensing()
MEASURED = MeasuredFeet()
JOINTS = zeros(12)
GOALS = zeros(12)
PLACE = Range(-(1 << 23), (1 << 23) - 1)
MOVED = Range(-(1 << 23), 1 << 23)
HIND = Range(2, 3)
NO_LEG = Range(-1, 3)
AXIS = Range(0, 2)
AHEAD = Range(-(1 << 20), 1 << 20)
TICKS = Range(0, 150)
CALF_PITCH = Range(-98304, 98303)
TILT = Range(-600, 600)
SPEED = Range(0, 200000)
SHARE = Range(0, 4096)
PREVIOUS = Range(0, 1000)


def _near(dice, bits):
    """Return a place along an axis, lf."""
    return (dice.bits(bits) << 1) - (1 << bits)


def _soil_map(dice, bits):
    for leg in range(4):
        for axis in range(3):
            MAP.feet[leg][axis] = _near(dice, bits)
            MAP.measured[leg][axis] = _near(dice, bits)
    for axis in range(6):
        MAP.body_pose[axis] = _near(dice, bits if axis < 3 else 22)
    for leg in range(4):
        MAP.calf_pitch[leg] = CALF_PITCH.any(dice)
        SUPPORT.stance[leg] = dice.bits(1)
        SUPPORT.share_q12[leg] = SHARE.any(dice)
        SUPPORT.force_q12[leg] = FORCE.any(dice)
        SUPPORT.load_q12[leg] = FORCE.any(dice)
    SUPPORT.weight_q12 = 2867 + dice.below(10240 - 2867)
    SUPPORT.weight_q20 = dice.below(16383 << 8)
    SUPPORT.payload_q12 = SHARE.any(dice)
    SUPPORT.diagonal_offset = dice.below(2 * 1342208) - 1342208
    SUPPORT.margin = PREVIOUS.any(dice)


def _soil_path(dice, bits):
    for axis in range(6):
        PATH.wanted[axis] = _near(dice, bits)
        PATH.from_pose[axis] = _near(dice, bits)
        PATH.to_pose[axis] = _near(dice, bits)
        PATH.lagged[axis] = _near(dice, bits)
        PATH.integral[axis] = _near(dice, bits)
        PATH.commanded[axis] = _near(dice, bits)
        PATH.deviation[axis] = _near(dice, bits)
    PATH.move_tick = dice.below(61)
    PATH.move_ticks = dice.below(61)
    for side in range(2):
        queue = FOOTHOLDS.sides[side]
        for place in range(MOST_FOOTHOLDS):
            for axis in range(3):
                queue.places[place][axis] = _near(dice, bits)
        queue.waiting = dice.below(5)
        queue.occupied = dice.bits(1)
        queue.guessed = dice.bits(2)


def _soil_swing(dice, bits):
    for axis in range(3):
        FOOT.place[axis] = _near(dice, bits)
        FOOT.target[axis] = _near(dice, bits)
    FOOT.departure.x = _near(dice, bits)
    FOOT.departure.y = _near(dice, bits)
    FOOT.ground = _near(dice, bits)
    FOOT.place.z = FOOT.ground - dice.bits(22)
    FOOT.apex = _near(dice, bits)
    FOOT.speed = SPEED.any(dice)
    FOOT.way_ticks = 1 + dice.below(60)
    FOOT.tries = dice.bits(2)
    FOOT.risers = dice.bits(2)
    FOOT.dropped = dice.below(3) - 1
    FOOT.known = dice.bits(1)
    FOOT.leg_length = dice.bits(15)
    FOOT.limited = dice.bits(1)
    CONTACT.tare_q12 = FORCE.any(dice)
    CONTACT.load_ticks = dice.below(10)
    CONTACT.peak = dice.bits(1)
    for at in range(HISTORY_TICKS):
        CONTACT.past_x[at] = _near(dice, bits)
    CONTACT.past_at = dice.below(HISTORY_TICKS)


def _soil_stage(dice):
    STAGE.stage = dice.below(6)
    STAGE.stage_tick = TICKS.any(dice)
    STAGE.order = dice.bits(2)
    STAGE.leg = dice.bits(2)
    STAGE.ahead = dice.below(1200000) - 600000
    EVENT.code = dice.bits(3)
    EVENT.leg = dice.bits(2)
    EVENT.number = PREVIOUS.any(dice)
    GROUND.landings = PREVIOUS.any(dice)
    GROUND.even_landings = PREVIOUS.any(dice)


def _soil(values, dice):
    """Fill the state: near the middle of the map every other time, where edges and drops are what is met."""
    bits = 23 if dice.bits(1) else 16
    _soil_map(dice, bits)
    _soil_path(dice, bits)
    _soil_swing(dice, bits)
    _soil_stage(dice)
    for at in range(12):
        SENSING.level[at // 3][at % 3] = dice.bits(16) - 32768
        JOINTS[at] = dice.bits(14) - 8192
        CRAWL.goals[at] = dice.bits(16) - 32768
        CRAWL.jumps[at] = _near(dice, bits)
        CRAWL.pose[at % 6] = dice.bits(14) - 8192
        CRAWL.feet.legs[at // 3][at % 3] = dice.bits(15) - 16384
        CRAWL.hip_feet.legs[at // 3][at % 3] = dice.bits(15) - 16384
    for leg in range(4):
        SENSING.force_q12[leg] = dice.bits(14) - 8192
    CRAWL.point.x = dice.bits(15) - 16384
    CRAWL.point.y = dice.bits(15) - 16384
    copy(ROBOT.any(dice), OWN)
    if dice.bits(1):
        OWN.lateral_q12 = 0


_stateful = probe_with(watch=STATE, fit=_soil)


class _Walk:
    """A crawl on level ground with joints that follow their goals half way each tick, and now and then on none."""

    def __init__(self):
        self.ticks = 0

    def begin(self):
        copy(PARAMS[0], OWN)
        sensing_reset(SENSING)
        self.ticks = 0

    def step(self, values, dice):
        if self.ticks % 400 == 0:
            self.start(dice)
        self.ticks += 1
        for joint in range(12):
            JOINTS[joint] += (GOALS[joint] - JOINTS[joint]) // 2 + dice.bits(5) - 16
        OWN.lateral_q12 = 0 if self.ticks // 400 & 1 else LATERAL_Q12
        sense_legs(PARAMS[0], JOINTS, values[3], values[4], MEASURED, SENSING)
        for leg in range(4):
            SENSING.force_q12[leg] = 1024 + dice.bits(8) if dice.bits(3) else 2000
            if leg == STAGE.leg and STAGE.stage in (LIFT, SWING, HANG):
                SENSING.force_q12[leg] = dice.bits(6)
        keep_sent(SENSING, GOALS)

    def start(self, dice):
        for leg in range(4):
            JOINTS[leg * 3] = dice.bits(9) - 256
            JOINTS[leg * 3 + 1] = 8000 + dice.bits(10)
            JOINTS[leg * 3 + 2] = -16000 - dice.bits(10)
        for joint in range(12):
            GOALS[joint] = JOINTS[joint]
        sense_legs(PARAMS[0], JOINTS, 0, 0, MEASURED, SENSING)
        crawl.crawl_start(CRAWL, SENSING, JOINTS, GOALS, 0, 0)


WALK = _Walk()
STEPS = Steps()
COMMAND = Command()
RETREAT = retreat.Retreat()
RETREAT_ROW = Row(RETREAT)
TOLD = Command()
FADE = Fade()
FADE_ROW = Row(FADE)


def _with_foothold(values, dice):
    _soil(values, dice)
    FOOTHOLDS.sides[values[2]].waiting = 1 + dice.bits(1)


def _with_weights(values, dice):
    """Fill the state; any weights of the feet, with their sum."""
    _soil(values, dice)
    total = 0
    for leg in range(4):
        CRAWL.weights[leg] = dice.below(257)
        total += CRAWL.weights[leg]
    values[2] = max(1, total)


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


_backing = probe_with(watch=(RETREAT,), fit=_any_retreat)
_walking = probe_with(begin=WALK.begin, fit=WALK.step, vectors=10)

PROBES = (
    Probe(filters, "fraction", (Range(-(1 << 25) + 1, (1 << 25) - 1), Range(0, 32768))),
    Probe(filters, "quintic_q15", (Range(-3, 1 << 29), Range(-3, 1 << 29))),
    Probe(swing_leg, "brake_speed", (Range(0, 1 << 29), UNIT)),
    _stateful(footholds, "footholds_start", (CRAWL,)),
    Probe(footholds, "foothold_line", (ROBOT, FLAG)),
    _stateful(footholds, "foothold_add", (MAP, FOOTHOLDS, FLAG)),
    Probe(footholds, "foothold_keep", (MAP, FOOTHOLDS, FLAG), watch=(FOOTHOLDS,), fit=_with_foothold),
    _stateful(footholds, "draw_back", (CRAWL, FLAG)),
    _stateful(footholds, "follow_front_feet", (CRAWL,)),
    _stateful(footholds, "foothold_drop", (FOOTHOLDS, FLAG)),
    _stateful(footholds, "aim", (CRAWL, LEG)),
    _stateful(footholds, "aim_front", (CRAWL, FLAG)),
    _stateful(footholds, "aim_hind", (CRAWL, HIND)),
    _stateful(footholds, "aim_hind_even", (CRAWL, HIND)),
    _stateful(footholds, "lay_between", (CRAWL, HIND)),
    _stateful(footholds, "steps_down", (CRAWL, LEG)),
    _stateful(footholds, "next_foothold_x", (FOOTHOLDS, HIND)),
    _stateful(contact, "take_tare", (ROBOT, CONTACT, FORCE, TICKS)),
    _stateful(contact, "start_contact", (CONTACT,)),
    _stateful(contact, "follow_tare", (ROBOT, CONTACT, FORCE, Range(0, 32768))),
    _stateful(contact, "feel_ground", (ROBOT, CONTACT, FORCE)),
    _stateful(contact, "corner_lift", (CRAWL, LEG)),
    _stateful(contact, "stands_straight", (ROBOT, UNIT, PLACE)),
    _stateful(contact, "keep_past", (CONTACT, PLACE)),
    _stateful(contact, "feel_riser", (CRAWL, PLACE)),
    _stateful(swing_leg, "lift_foot", (ROBOT, FOOT)),
    _stateful(swing_leg, "start_swing", (CRAWL,)),
    _stateful(swing_leg, "swing_foot", (CRAWL,)),
    _stateful(swing_leg, "lower_acceleration", (CRAWL,)),
    _stateful(swing_leg, "lower_speed", (CRAWL,)),
    _stateful(swing_leg, "lower_foot", (CRAWL,)),
    _stateful(crawl_map, "roll_feet", (CRAWL, JOINTS)),
    _stateful(crawl_map, "weigh_feet", (CRAWL,), watch=(CRAWL.weights,)),
    _stateful(crawl_map, "fit_heading", (CRAWL, SENSING, 1), fit=_with_weights),
    _stateful(crawl_map, "turn_feet", (SENSING, MAP)),
    _stateful(crawl_map, "fit_body", (CRAWL, SENSING)),
    _stateful(crawl_map, "follow_slips", (CRAWL,)),
    _stateful(crawl_map, "mean_foot", (MAP, AXIS)),
    _stateful(crawl_map, "front_to_hind", (MAP, AXIS)),
    _stateful(crawl_pose, "feet_pitch", (ROBOT, MAP)),
    Probe(crawl_pose, "com_ahead", (ROBOT, BRAD)),
    Probe(crawl_pose, "take_feet", (CRAWL,), watch=(CRAWL.feet,), fit=_soil),
    _stateful(crawl_pose, "com_target", (CRAWL, LEG, UNIT)),
    _stateful(crawl_pose, "resting_x", (CRAWL,)),
    _stateful(crawl_pose, "longest_leg", (CRAWL, NO_LEG)),
    _stateful(crawl_pose, "plan_body", (CRAWL, NO_LEG)),
    _stateful(crawl_pose, "start_body", (CRAWL,)),
    _stateful(crawl_pose, "move_ticks", (CRAWL,)),
    _stateful(crawl_pose, "move_body", (PATH,)),
    _stateful(crawl_pose, "hold_pose", (CRAWL,)),
    _stateful(crawl_goals, "foot_offset", (SUPPORT, LEG)),
    _stateful(crawl_goals, "plan_loads", (CRAWL,)),
    _stateful(crawl_goals, "take_pose", (CRAWL, FLAG)),
    _stateful(crawl_goals, "foot_in_body", (CRAWL, LEG, PLACE, PLACE, PLACE)),
    _stateful(crawl_goals, "place_foot", (CRAWL, LEG, FLAG)),
    _stateful(crawl_goals, "leg_goal", (CRAWL, LEG, FLAG)),
    _stateful(crawl_goals, "absorb_jump", (CRAWL, LEG, FLAG)),
    _stateful(crawl_goals, "solve_legs", (CRAWL,)),
    _stateful(crawl_goals, "legs_goals", (CRAWL, GOALS)),
    _stateful(crawl_steps, "enter", (CRAWL, Range(0, 5))),
    _stateful(crawl_steps, "note_event", (CRAWL, Range(0, 8), PLACE)),
    _stateful(crawl_steps, "start_stages", (CRAWL,)),
    _stateful(crawl_steps, "take_stage", (CRAWL, AHEAD)),
    _stateful(crawl_steps, "swing_stage", (CRAWL, LEG)),
    _stateful(crawl_steps, "plan_shift", (CRAWL,)),
    _stateful(crawl_steps, "hip_over", (CRAWL, LEG, PLACE)),
    _stateful(crawl_steps, "shift_to", (CRAWL, LEG, UNIT, NO_LEG)),
    _stateful(crawl_steps, "shift_tick", (CRAWL, LEG)),
    _stateful(crawl_steps, "match_diagonals", (CRAWL, LEG)),
    _stateful(crawl_steps, "lift_off", (CRAWL, LEG)),
    _stateful(crawl_steps, "swing_tick", (CRAWL, LEG)),
    _stateful(crawl_steps, "hang_tick", (CRAWL, LEG)),
    _stateful(crawl_steps, "put_down", (CRAWL, LEG)),
    _stateful(crawl_steps, "lower_tick", (CRAWL, LEG)),
    _stateful(crawl_steps, "lift_again", (CRAWL, PLACE, PLACE)),
    _stateful(crawl_steps, "free_calf", (CRAWL, LEG)),
    _stateful(crawl_steps, "touch", (CRAWL, LEG, PLACE)),
    _stateful(crawl_steps, "find_ground", (CRAWL, LEG)),
    _stateful(crawl_steps, "drop_front", (CRAWL, FLAG)),
    _stateful(crawl_steps, "drop_hind", (CRAWL, HIND)),
    _stateful(crawl_steps, "leave_rim", (CRAWL, PLACE)),
    _stateful(crawl_steps, "leave_drop", (CRAWL, PLACE)),
    _stateful(crawl_steps, "land", (CRAWL, LEG)),
    _stateful(crawl_ground, "note_landing", (CRAWL, LEG)),
    _stateful(crawl_ground, "unevenness", (CRAWL, LEG)),
    _stateful(crawl_ground, "feet_length", (MAP,)),
    _stateful(crawl_ground, "feet_rise", (MAP,)),
    _stateful(crawl_ground, "expected_rise", (CRAWL, AHEAD)),
    Probe(crawl_ground, "off_slope", (PLACE, PLACE, Range(1, 16383), FORCE)),
    _stateful(crawl, "crawl_reset", (CRAWL,)),
    _stateful(crawl, "start_map", (CRAWL, SENSING, JOINTS, TILT, TILT)),
    _stateful(crawl, "start_support", (SENSING, SUPPORT)),
    _stateful(crawl, "take_tilt", (OWN, MAP, TILT, TILT)),
    _stateful(crawl, "update_weight", (ROBOT, SENSING, SUPPORT)),
    _stateful(crawl, "recentre_map", (CRAWL,)),
    _stateful(crawl, "move_origin", (CRAWL, AXIS, PLACE)),
    _stateful(crawl, "estimate", (CRAWL, SENSING, JOINTS, TILT, TILT)),
    _stateful(crawl, "crawl_start", (CRAWL, SENSING, JOINTS, GOALS, TILT, TILT)),
    _backing(retreat, "retreat_start", (RETREAT,)),
    _backing(retreat, "retreat_step", (ROBOT, COMMAND, MOVED, FLAG, RETREAT, TOLD), watch=(TOLD, RETREAT)),
    Probe(handover, "crawl_can_follow", (ROBOT, COMMAND), fit=_any_speed),
    _stateful(crawl_ground, "even_for_trot", (GROUND,)),
    _stateful(crawl_ground, "long_strides", (GROUND,)),
    _stateful(crawl_ground, "stride_lf", (CRAWL,)),
    Probe(handover, "fade_start", (ROBOT, FADE, JOINTS), watch=(FADE,), fit=_any_fade),
    Probe(handover, "fade_out", (FADE, JOINTS), watch=(FADE, JOINTS), fit=_any_fade),
    _walking(crawl, "crawl_tick", (CRAWL, SENSING, JOINTS, TILT, TILT, AHEAD, GOALS), watch=(GOALS,) + STATE),
)
