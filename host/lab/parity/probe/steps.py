"""shared/gait/steps.py: feet anywhere in their stride, in every gait, at every speed the gait allows."""


from shared.body.axes import TWIST_AXES, Twist
from shared.body.feet import Feet
from shared.body.params import LF_BITS, Params
from shared.gait import steps
from shared.gait.table import Clock, Gait

from .draw import LEG, Range
from .draws import ROBOT, TABLE, TABLES, gait_of
from .gait import any_clock, draw_clock
from .probe import Probe, probe_with
from .robots import PARAMS
from .row import Row

STEPS = steps.Steps()
ROW = Row(STEPS)
SPEED = Twist()
CLOCK = Clock()
FEET = Feet()
HEIGHT = Range(0, 6000)
SPEED_LF = Range(-(1 << 19) + 1, (1 << 19) - 1)
TICKS_Q10 = Range(0, (1 << 24) - 1)
ARM = Range(-65535 << LF_BITS, 65535 << LF_BITS)
SHARE = Range(0, 32768)
PEAK = Range(0, 8191)


def _draw_speed(gait: Gait, dice):
    for axis in range(TWIST_AXES):
        top = gait.speed_max[axis]
        SPEED[axis] = dice.below(2 * top + 1) - top


def _draw_steps(params, dice):
    """Feet within a stride of rest; some of them in swing, at any sample of it."""
    steps.steps_reset(params, STEPS)
    for leg in range(4):
        step = STEPS.legs[leg]
        step.x += dice.bits(20) - (1 << 19)
        step.y += dice.bits(20) - (1 << 19)
        step.to_z += dice.bits(10) - (1 << 9)
        if dice.bits(1):
            step.ticks = 1 + dice.below(200)
            step.tick = dice.below(step.ticks)
            step.left_q10 = dice.bits(17)


def _soiled(values, dice):
    _draw_steps(values[0], dice)


def _near_rest(values, dice):
    steps.steps_reset(values[0], STEPS)
    if dice.bits(1):
        ROW[dice.below(len(ROW))] += dice.below(41) - 20


def _start(values, dice):
    params = ROBOT.any(dice)
    values[0] = gait_of(params, values[0])
    draw_clock(values[0], CLOCK, dice)
    _draw_steps(params, dice)


def _shorten_way(values, dice):
    speed, ticks = values
    while abs(speed) * (ticks >> 10) >= 1 << 23:
        ticks >>= 1
    values[1] = ticks


def _shorten_turn(values, dice):
    turn, _, ticks = values
    while abs(turn) * (ticks >> 10) >= 1 << 18:
        ticks >>= 1
    values[2] = ticks


def _moving(values, dice):
    params = ROBOT.any(dice)
    _draw_speed(gait_of(params, dice.below(len(TABLES))), dice)
    _draw_steps(params, dice)


def _walking(values, dice):
    values[1] = gait_of(values[0], values[1])
    _draw_speed(values[1], dice)
    _draw_steps(values[0], dice)


def _swinging(values, dice):
    _walking(values, dice)
    step = STEPS.legs[values[4]]
    step.ticks = 1 + dice.below(200)
    step.tick = dice.below(step.ticks)


def _ahead(values, dice):
    _draw_speed(gait_of(values[0], dice.below(len(TABLES))), dice)


def _near_line(values, dice):
    params: Params = PARAMS[0]
    rest = params.legs[dice.bits(2)].rest.x << LF_BITS
    values[0] = rest + (values[0] >> 4)
    values[1] = rest + (values[1] >> 4)


_placing = probe_with(watch=(STEPS, FEET))

PROBES = (
    Probe(steps, "steps_reset", (ROBOT, STEPS), watch=(STEPS,), fit=_soiled),
    Probe(steps, "steps_at_rest", (ROBOT, STEPS), fit=_near_rest),
    Probe(steps, "start_swings", (TABLE, CLOCK, STEPS), watch=(STEPS,), fit=_start),
    Probe(steps, "body_advance", (TABLE, CLOCK), watch=(CLOCK,), fit=any_clock),
    Probe(steps, "travel", (SPEED_LF, TICKS_Q10), fit=_shorten_way),
    Probe(steps, "turned_travel", (Range(-16383, 16383), ARM, TICKS_Q10), fit=_shorten_turn),
    Probe(steps, "move_feet", (STEPS, SPEED, PEAK), watch=(STEPS,), fit=_moving),
    _placing(steps, "place_feet", (ROBOT, TABLE, STEPS, SPEED, HEIGHT, FEET), fit=_walking, vectors=2),
    _placing(steps, "swing_foot", (ROBOT, TABLE, STEPS, SPEED, LEG, HEIGHT, FEET), fit=_swinging),
    Probe(steps, "between", (ARM, ARM, SHARE)),
    Probe(steps, "between:near", (ARM, ARM, SHARE), fit=_near_line),
    Probe(steps, "foothold_x", (ROBOT, LEG, SPEED, Range(0, 1 << 17)), fit=_ahead),
    Probe(steps, "foothold_y", (ROBOT, LEG, SPEED, Range(0, 1 << 17)), fit=_ahead),
)
