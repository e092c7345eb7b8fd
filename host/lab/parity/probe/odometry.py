"""shared/sense/odometry.py: legs anywhere in a tick after legs near or far, anywhere along the way."""

from shared.sense import legs, odometry
from shared.sense.legs import Sensing
from shared.sense.odometry import Odometry
from shared.sense.sensed import Sensed

from .draw import BRAD, FLAG, FORCE, INT30, LEG, UNIT, Range
from .draws import ROBOT
from .probe import Block, probe_with
from .row import clear
from .sensing import ANGLES

SENSING = Sensing()
MEASURED = legs.MeasuredFeet()
SENSED = Sensed()
WAY = Odometry()
SWINGING = Range(0, 15)
TURN = Range(-32768, 32768)
WEIGHTS = Range(253, 256)
SLIP = Range(0, 131068)
TURNED = Block(SENSED.turned, (3, INT30))
FAR, SUM = 0x3FFF0000, 0x3F000000


def _begin():
    for block in (ANGLES.array, SENSING, WAY, SENSED.valid, SENSED.turned, SENSED.tilt):
        clear(block)
    legs.sensing_reset(SENSING)


def _walk(values, dice):
    """A tick of the drawn robot with joints near those before or anywhere, as heavy as may be, along any way."""
    params = values[0]
    far = dice.below(8) == 0
    for joint in range(12):
        near = ANGLES.array[joint] + dice.bits(8) - 128
        ANGLES.array[joint] = BRAD.any(dice) if far else min(32767, max(-32768, near))
    legs.keep_sent(SENSING, ANGLES.array)
    roll_brad = BRAD.any(dice) if far else dice.bits(10)
    legs.sense_legs(params, ANGLES.array, roll_brad, -dice.bits(10), MEASURED, SENSING)
    for leg in range(4):
        SENSING.force_q12[leg] = dice.bits(15) - 16384
    for axis in range(3):
        SENSED.turned[axis] = INT30.any(dice) if far else dice.bits(12) - 2048
    SENSED.valid.tilt = 1 if dice.bits(3) else 0
    SENSED.valid.turned = 1 if dice.bits(2) else 0
    if dice.below(20) == 0:
        _anywhere(dice)
    odometry.odometry_step(params, SENSING, SENSED, SWINGING.any(dice), dice.bits(1), WAY)


def _anywhere(dice):
    """All that adds up near its ends."""
    for axis in range(2):
        WAY.place[axis] = FAR - dice.bits(20) if dice.bits(1) else dice.bits(20) - FAR
        WAY.heading_spread[axis] = SUM - dice.bits(20) if dice.bits(1) else dice.bits(20) - SUM
    WAY.walked = dice.bits(30) & FAR
    WAY.slip = WAY.walked >> dice.bits(3)
    WAY.heading_sigma_q26 = SUM - dice.bits(20)
    WAY.heading = 0x7FFFFF - dice.bits(10)


def _any_robot(values, dice):
    _walk([ROBOT.any(dice)], dice)


_probe = probe_with(watch=(WAY,), fit=_walk, begin=_begin)

PROBES = (
    _probe(odometry, "odometry_lost", (WAY,), fit=_any_robot),
    _probe(odometry, "odometry_restart", (WAY,), fit=_any_robot),
    _probe(odometry, "odometry_step", (ROBOT, SENSING, SENSED, SWINGING, FLAG, WAY), vectors=4),
    _probe(odometry, "weigh_feet", (ROBOT, SENSING, SWINGING, WAY)),
    _probe(odometry, "stance_force", (ROBOT, FLAG, LEG, FORCE, WAY)),
    _probe(odometry, "lasting_load_q6", (FORCE, LEG, WAY), fit=_any_robot),
    _probe(odometry, "turn_of_body", (SENSING, TURNED), watch=(), fit=_any_robot),
    _probe(odometry, "measure_feet", (SENSING, WEIGHTS, WAY), fit=_any_robot),
    _probe(odometry, "turn_of_feet", (WAY,), watch=(), fit=_any_robot),
    _probe(odometry, "move_body", (ROBOT, TURN, WEIGHTS, FLAG, WAY)),
    _probe(odometry, "place_body", (UNIT, UNIT, TURN, FLAG, WAY), fit=_any_robot),
    _probe(odometry, "add_distance", (ROBOT, UNIT, UNIT, SLIP, WAY)),
    _probe(odometry, "odometry_spread", (ROBOT, WAY)),
)
