"""shared/trot/trot.py: its parts in states that a few ticks of anything bring about, for every robot and rate."""


from shared.gait.gaits import TROT
from shared.gait.steps import SPEED_SIZE, Steps, steps_reset
from shared.gait.table import Clock, compile_gait
from shared.runtime import zeros
from shared.trot import trot

from .draw import Range
from .draws import BRAD
from .probe import Block, Pick, Probe
from .robots import PARAMS

SOURCES = ("trot.trot",)

PLACE = Range(-18900, 18900)  # three squares of it are below 2^30
ANGLES = Block(zeros(12), (12, BRAD))
REACHED = Block(zeros(12), (12, PLACE))
POSED = Block(zeros(6), (3, Range(-65535, 65535)), (3, BRAD))
SPEED = Block(zeros(SPEED_SIZE), (3, Range(-(1 << 19) + 1, (1 << 19) - 1)))
DRIVE = zeros(SPEED_SIZE)
STEPS = Steps()
CLOCK = Clock()
FLAG = Range(0, 1)
GAIT_OF = [compile_gait(TROT, params) for params in PARAMS]
WALK = trot.Trot(PARAMS[0])
ROBOT = Pick(*PARAMS)
STATE = (WALK.state, WALK.load, WALK.nav, WALK.tip)
RATE = Range(-(1 << 15), (1 << 15) - 1)
SQUARE = Range(0, (1 << 30) - 1)


def _begin():
    trot.trot_reset(PARAMS[0], WALK)
    steps_reset(PARAMS[0], STEPS)
    for block in (WALK.body, WALK.contact, WALK.weights, DRIVE):
        for at in range(len(block)):
            block[at] = 0
    for at in range(len(PARAMS)):
        trot.retime(PARAMS[at], GAIT_OF[at], DRIVE)


def _clock(params, dice):
    """Put the clock anywhere in the gait of a robot; return that gait."""
    CLOCK.segment = dice.below(4)
    CLOCK.tick = dice.below(12)
    for at in range(len(PARAMS)):
        if PARAMS[at] is params:
            return GAIT_OF[at]
    raise ValueError("not one of the robots")


def _live(values, dice):
    """One tick of anything on the drawn robot; a gait argument becomes that robot's."""
    params = values[0]
    if dice.below(40) == 0:
        trot.trot_reset(params, WALK)
    for axis in range(3):
        WALK.state.turned[axis] = RATE.any(dice)
    WALK.state.turned_known = dice.bits(1)
    ANGLES.fill(dice)
    REACHED.fill(dice)
    SPEED.fill(dice)
    gait = _clock(params, dice)
    trot.feel_legs(params, WALK, ANGLES.array, 1 if dice.bits(3) else 0, BRAD.any(dice), BRAD.any(dice))
    trot.drive_speed(params, WALK, SPEED.array, DRIVE)
    trot.sway_body(params, WALK, gait, CLOCK, 1)
    WALK.state.far = SQUARE.any(dice)
    trot.raise_body(params, WALK, dice.bits(1))
    trot.share_weight(params, WALK, REACHED.array, 9 if dice.bits(1) else 0, 1)


def _with_gait(at):
    def fit(values, dice):
        _live(values, dice)
        values[at] = _clock(values[0], dice)

    return fit


def _part(name, arguments, watch=STATE, fit=_live):
    return Probe(name, getattr(trot, name), arguments, watch=watch, fit=fit, begin=_begin)


PROBES = (
    _part("trot_reset", (ROBOT, WALK)),
    _part("trot_start", (ROBOT, WALK)),
    _part("feel_legs", (ROBOT, WALK, ANGLES, FLAG, BRAD, BRAD)),
    _part("feel_ground", (ROBOT, WALK, STEPS, BRAD, BRAD, BRAD, BRAD), STATE + (STEPS,)),
    _part("drive_speed", (ROBOT, WALK, SPEED, DRIVE), STATE + (DRIVE,)),
    _part("retime", (ROBOT, 0, SPEED), (), _with_gait(1)),
    _part("begin_segment", (ROBOT, WALK, 0, CLOCK, SPEED, SPEED), STATE, _with_gait(2)),
    _part("sway_body", (ROBOT, WALK, 0, CLOCK, FLAG), STATE, _with_gait(2)),
    _part("learn_centre", (ROBOT, WALK, CLOCK)),
    _part("raise_body", (ROBOT, WALK, FLAG)),
    _part("pose_body", (ROBOT, WALK, BRAD, BRAD, POSED), (POSED.array,)),
    _part("share_weight", (ROBOT, WALK, REACHED, Range(0, 15), FLAG)),
)
