"""What a leg in the air feels: ground under the foot, an edge under the calf, a riser in front.

There is no foot switch: the vertical force comes from the joints' errors. A leg that hangs reads its own
weight and its friction; that tare is taken before it goes down and followed while nothing touches.
"""

from ..body.params import LF_BITS, RR, Params
from ..num.filters import fraction
from ..num.fixed import saturate
from ..runtime import const, hot
from .state import HISTORY_TICKS, Contact, Crawl

_MOST_RISERS = const(2)
_RAD_BRAD = const(10430)  # 65536 / 2 pi


@hot
def take_tare(params: Params, contact: Contact, force_q12: int, tick: int) -> None:
    """Take tick ``tick`` of the hanging leg's force into its tare."""
    gain_q15 = params.crawl.tare_in_q15
    if tick <= params.crawl.hang_skip_ticks + 1:
        gain_q15 = 0x8000
    follow_tare(params, contact, force_q12, gain_q15)


@hot
def follow_tare(params: Params, contact: Contact, force_q12: int, gain_q15: int) -> int:
    """Bring the tare nearer to ``force`` by a share; return it, Q12 of the own weight.

    It is at most what makes a contact: the load of a leg that touches already while it hangs is not hidden in it.
    """
    most = params.crawl.touch_q12
    tare_q12 = contact.tare_q12 + fraction(force_q12 - contact.tare_q12, gain_q15)
    contact.tare_q12 = saturate(tare_q12, -most, most)
    return contact.tare_q12


@hot
def start_contact(contact: Contact) -> None:
    """Begin to feel for the ground."""
    contact.load_ticks = 0
    contact.peak = 0


@hot
def feel_ground(params: Params, contact: Contact, force_q12: int) -> int:
    """Return 1 when the foot on its way down has ground under it, else 0.

    That is more than 3 N above the tare for 60 ms, with more than 4 N once in them (on Caramelo; in parts of
    the weight on others). Without load the tare follows.
    """
    force = force_q12 - contact.tare_q12
    if force > params.crawl.touch_q12:
        contact.load_ticks += 1
        if force > params.crawl.peak_q12:
            contact.peak = 1
    else:
        start_contact(contact)
        follow_tare(params, contact, force_q12, params.crawl.tare_down_q15)
    if contact.load_ticks >= params.crawl.contact_ticks and contact.peak:
        return 1
    return 0


@hot
def corner_lift(crawl: Crawl, leg: int) -> int:
    """Return by how much the body's corner over ``leg`` is above its plan, lu: pushed up from below.

    Pitch lowers the front, roll raises the left. Angles limited to +-4096 brad. Largest intermediate
    2 * 32767 * 4096 < 2^29.
    """
    params = crawl.params
    map = crawl.map
    path = crawl.path
    nose_up = saturate(path.wanted.pitch - map.body_pose.pitch >> LF_BITS, -4096, 4096)
    left_up = saturate(map.body_pose.roll - path.wanted.roll >> LF_BITS, -4096, 4096)
    lift = nose_up * params.crawl.half_length
    if leg >= RR:
        lift = -lift
    if leg & 1:
        lift += left_up * params.crawl.half_width
    else:
        lift -= left_up * params.crawl.half_width
    return lift // _RAD_BRAD


@hot
def stands_straight(params: Params, lift: int, off_lf: int) -> int:
    """Return 1 if a foot near its expected ground pushes the body's corner up by ``lift`` (lu): it stands; else 0.

    A nearly straight leg shows no load in its joints. off: of the foot above the expected ground, lf; near is within
    what counts as even. Farther off, it may be the calf that pushes, on an edge.
    """
    even = params.crawl.drop_depth // 3 << LF_BITS
    if lift > params.crawl.stand_lift and off_lf < even and off_lf > -even:
        return 1
    return 0


@hot
def keep_past(contact: Contact, x_lf: int) -> None:
    """Keep where the foot is sent in this tick, for the riser."""
    at = contact.past_at + 1
    if at >= HISTORY_TICKS:
        at = 0
    contact.past_x[at] = x_lf
    contact.past_at = at


@hot
def feel_riser(crawl: Crawl, measured_x_lf: int) -> int:
    """Return 1 if the moving foot is held up: farther behind its command of 60 ms ago than its speed explains.

    measured_x: of the foot by the measured joints, lf.
    """
    params = crawl.params
    contact = crawl.contact
    swing = crawl.swing
    if crawl.stage.stage_tick <= params.crawl.riser_skip_ticks or swing.risers >= _MOST_RISERS or swing.limited:
        return 0
    at = contact.past_at - params.crawl.goal_lag_ticks
    if at < 0:
        at += HISTORY_TICKS
    behind = contact.past_x[at] - measured_x_lf >> LF_BITS
    way = swing.target.x - swing.departure.x >> LF_BITS
    if way < 0:
        way = -way
    if behind > params.crawl.riser_lag + way * params.crawl.swing_lag_ticks // (swing.way_ticks + 1):
        return 1
    return 0
