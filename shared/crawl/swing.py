"""The path of one foot through the air: up, across, hang a moment, down until something is felt.

The positions are map places in lf, so the path does not depend on what the body does meanwhile.
Profiles: up, braked below the apex, a quintic across, down at a steady speed; faster where the ground is known or even,
and steady again shortly above it. A foot that feels load goes on slowly. On even ground the way across is quicker, too.
"""

from ..body.params import LF_BITS, Params
from ..num.filters import fraction, quintic_q15
from ..num.fixed import hypot, isqrt, saturate
from ..runtime import const, hot
from .ground import long_strides
from .state import Crawl, Swing

_PRODUCT_MAX = const(0x3FFFFFFF)


@hot
def brake_speed(brake: int, way_lu: int) -> int:
    """Return the speed, lf / tick, from which ``brake`` / 2 (lf / tick^2) stops within ``way`` (lu): sqrt(brake * way).

    Range: brake 0 .. 2^29; the way is limited to what keeps the product below 2^30: a lower speed than could
    be. Error at most 16 lf / tick.
    """
    return isqrt(brake * saturate(way_lu, 0, _PRODUCT_MAX // (brake + 1))) << 4


@hot
def lift_foot(params: Params, swing: Swing) -> int:
    """Take one tick upwards; return 1 at the apex. A leg that is folded already has its apex where it is."""
    speed = swing.speed + params.crawl.lift_acceleration
    way = swing.apex - swing.place.z >> LF_BITS
    braked_speed = brake_speed(params.crawl.lift_brake, way) + params.crawl.apex_speed
    if speed > braked_speed:
        speed = braked_speed
    if speed > params.crawl.lift_speed:
        speed = params.crawl.lift_speed
    swing.speed = speed
    z = swing.place.z + speed
    if z > swing.apex:
        z = swing.apex
    if swing.leg_length < params.crawl.folded:
        swing.apex = z
    if swing.place.z < z:
        swing.place.z = z
    if z < swing.apex:
        return 0
    return 1


@hot
def start_swing(crawl: Crawl) -> None:
    """Begin the way across to the target from where the foot is. Ways within +-65535 lu."""
    params = crawl.params
    swing = crawl.swing
    swing.departure.x = swing.place.x
    swing.departure.y = swing.place.y
    way = hypot(swing.target.x - swing.place.x >> LF_BITS, swing.target.y - swing.place.y >> LF_BITS)
    speed = params.crawl.swing_speed
    if long_strides(crawl.ground):
        speed = params.crawl.quick_swing_speed
    ticks = (way << LF_BITS) // speed
    if ticks < params.crawl.swing_ticks:
        ticks = params.crawl.swing_ticks
    swing.way_ticks = ticks


@hot
def swing_foot(crawl: Crawl) -> int:
    """Take one tick across; return 1 when the foot is there and the body's move has ended too, else 0."""
    swing = crawl.swing
    path = crawl.path
    tick = crawl.stage.stage_tick
    share = quintic_q15(tick, swing.way_ticks)
    for axis in range(2):
        swing.place[axis] = swing.departure[axis] + fraction(swing.target[axis] - swing.departure[axis], share)
    if tick < swing.way_ticks or path.move_tick < path.move_ticks:
        return 0
    return 1


@hot
def lower_acceleration(crawl: Crawl) -> int:
    """Return how fast the speed of the foot may change on its way down, lf / tick^2."""
    if long_strides(crawl.ground):
        return crawl.params.crawl.quick_lower_acceleration
    return crawl.params.crawl.lower_acceleration


@hot
def lower_speed(crawl: Crawl) -> int:
    """Return the speed, lf / tick, at which the foot may come down here.

    With load on it: slow. Over unknown ground: steady. Far above known or even ground faster, so that it can slow down
    to that in time: v^2 = steady^2 + 2 a h. Intermediates: those of brake_speed and hypot.
    """
    params = crawl.params
    swing = crawl.swing
    if crawl.contact.load_ticks:
        return params.crawl.loaded_lower_speed
    fastest = params.crawl.unknown_lower_speed
    if long_strides(crawl.ground):
        fastest = params.crawl.quick_lower_speed
    elif swing.known:
        fastest = params.crawl.known_lower_speed
    above = (swing.place.z - swing.ground >> LF_BITS) - params.crawl.near_foothold
    speed = params.crawl.unknown_lower_speed
    if above > 0:
        speed = hypot(brake_speed(2 * lower_acceleration(crawl), above), speed)
    if speed > fastest:
        speed = fastest
    return speed


@hot
def lower_foot(crawl: Crawl) -> None:
    """Take one tick down: the foot, or where the leg is at its longest the body."""
    params = crawl.params
    path = crawl.path
    swing = crawl.swing
    speed = swing.speed + lower_acceleration(crawl)
    most = lower_speed(crawl)
    if speed > most:
        speed = most
    swing.speed = speed
    lowest = crawl.map.body_pose.z - (params.crawl.position_limit << LF_BITS)
    if swing.leg_length > params.crawl.swing_reach and path.wanted.z > lowest:
        path.wanted.z -= params.crawl.body_speed
    else:
        swing.place.z -= speed
