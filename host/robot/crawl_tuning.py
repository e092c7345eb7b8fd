"""A robot's numbers for the crawl at a rate (shared/body/crawl_setup.py): its table, scaled to the leg, and its shape.

A robot file's table ``crawl`` overrides single numbers, in SI. The keys are the fields with their units, such as
``margin_m``, ``lift_speed_m_s``, ``settle_s``.
"""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from math import pi
from typing import NamedTuple

from shared.body.crawl_setup import CrawlSetup
from shared.body.params import CALF, FR, LEGS, LF_BITS, RR, THIGH, Leg, Params
from shared.num.fixed import cos_q15, hypot, isqrt
from sim2d.model import GRAVITY_M_S2

from .drives import joint_drives
from .model import Robot

_LEG_MM = 240  # the leg that the table's lengths belong to
_HEIGHT_MM = 185  # of its hips, from which the body has the table's accelerations
_STRIDE_MM = 90  # the longest
_LEAST_BEND = round(32768 * 30 / 180)  # brad, of a calf: the joints' errors show a foot's load times its sine
_SECOND_US = 1_000_000
_MM_THOUSANDTHS = 1_000_000  # in a metre


class _Unit(NamedTuple):
    """A unit of the core: how a field and its key in the file end, and how many of the table's units are 1 in SI."""

    name_end: str
    key_end: str
    per_si: int = 1000
    goes_with_leg: bool = False


_UNITS = {
    "lu": _Unit("", "_m", goes_with_leg=True),
    "lf / tick": _Unit("", "_m_s", goes_with_leg=True),
    "lf / tick^2": _Unit("", "_m_s2", goes_with_leg=True),
    "lu / s^2": _Unit("", "_m_s2"),  # the body's accelerations: gravity does not go with the leg
    "ticks": _Unit("_ticks", "_s"),
    "Q15 / tick": _Unit("_q15", "_s"),
    "brad": _Unit("", "_rad"),
    "Q15": _Unit("_q15", ""),
    "own weight": _Unit("_q12", "_weights", 10000),
}
_NUMBERS = {name: place for name, place in CrawlSetup.FIELDS if place.default}  # type: ignore[attr-defined]
_KEYS = {
    name.removesuffix(_UNITS[place.unit].name_end) + _UNITS[place.unit].key_end: name
    for name, place in _NUMBERS.items()
}
# Damping of the body's sway from which the pose loop has the table's gains: with them Parallel (10.4) stands still, and
# A1 (7.3) swayed until it fell
_CALM_1_S = 10.0
# Friction of a thigh or calf joint, as a share of the weight on a foot half a leg away, at which a contact has the
# table's least loads: Caramelo's. A1's is 0.008: the table's loads would tip it over before it notices them
_FRICTION_SHARE = 0.0219
# Of the weight, by a foot on an unexpected step: Caramelo, SpotMicro and A1 stay up with it, Parallel fell with 1.2
_MOST_PUSH = 0.7
# Of the leg, by which a body leans aside over a foot that met ground: of drawn robots two fell in the crawl on level
# ground with 0.05, whose feet are close together under stiff legs
_MOST_LEAN = 0.04
_MOST_LAG_S = 0.062  # the core keeps the goals of 31 ticks, at up to 500 Hz


def crawl_complaints(given: Mapping[str, float], leg_m: float) -> Iterator[tuple[str, object, str]]:
    """Yield (key, value, what is allowed) of each number in a table ``crawl`` that can't be used."""
    for key, value in given.items():
        if key not in _KEYS:
            hint = "".join(f"did you mean {close}? " for close in get_close_matches(key, _KEYS, 1))
            yield f"crawl.{key}", value, f"{hint}the keys are those of shared/body/crawl_setup.py: {', '.join(_KEYS)}"
            continue
        place = _NUMBERS[_KEYS[key]]
        usual = place.default * _one(place.unit, leg_m)
        low, high = sorted((usual / 4, usual * 2))
        if _KEYS[key] == "goal_lag_ticks":
            high = _MOST_LAG_S
        if not low <= value <= high:
            yield f"crawl.{key}", value, f"{low:.4g} .. {high:.4g}, a quarter to twice the usual {usual:.4g}"


def fill_crawl(params: Params, robot: Robot) -> None:
    """Write the crawl's numbers into parameters that already have rate, legs and leg length."""
    given, leg_m = robot.crawl, robot.geometry.leg_m
    for name, place in _NUMBERS.items():
        setattr(params.crawl, name, _scaled(place.default * 1000, place.unit, params))
    _shape(params)
    _calm(params, robot)
    _feel(params, robot)
    _soften(params, robot)
    _steady(params, robot)
    for key, value in given.items():
        place = _NUMBERS[_KEYS[key]]
        thousandths = round(1000 * value / _one(place.unit, leg_m))
        setattr(params.crawl, _KEYS[key], _scaled(thousandths, place.unit, params))


def _one(unit: str, leg_m: float) -> float:
    """Return the SI value of 1 in the table, for a leg."""
    return 1 / _UNITS[unit].per_si * (leg_m * 1000 / _LEG_MM if _UNITS[unit].goes_with_leg else 1)


def _scaled(value: int, unit: str, params: Params) -> int:
    """Return the core's value of a thousandth of a number of the table, for a robot's leg and rate."""
    rate_hz = params.rate_hz
    if unit in ("brad", "Q15", "own weight"):
        one = {"brad": 32768 / pi, "Q15": 32768, "own weight": 4096}[unit]
        return round(value / 1000 / _UNITS[unit].per_si * one)
    if unit == "ticks":
        return max(1, (value * rate_hz + _SECOND_US // 2) // _SECOND_US)
    if unit == "Q15 / tick":
        return min(32768, max(1, (32768 * _SECOND_US // value + rate_hz // 2) // rate_hz))
    if not _UNITS[unit].goes_with_leg:
        return (value << params.length_shift) // _MM_THOUSANDTHS
    length = params.leg_length * value // (_LEG_MM * 1000)
    if unit == "lu":
        return length
    step = (length << LF_BITS) // rate_hz
    return max(1, step if unit == "lf / tick" else step // rate_hz)


def _shape(params: Params) -> None:
    """Write what follows from hips and legs: the hips are carried at 0.865 of the straightest leg.

    Caramelo's are at 185 mm of 214: straighter knees need less torque. The lower they are for the leg, the faster the
    body may be: the zero-moment point stays as far inside the support as Caramelo's. No leg gets so straight that it
    does not feel its load: Solo 12 and SpotMicro did not notice the ground behind a drop. A trot's foot goes no higher
    than half way from the hip's offset to the shortest leg below the hip (clearance): up to there, its leg's direction
    turns by no more than the foot's way over that depth. Above it the joints reach only to the ends of thigh and calf.
    """
    crawl, front = params.crawl, params.legs[FR]
    length = front.hip.x - params.legs[RR].hip.x
    crawl.stride = min(length // 3, params.leg_length * _STRIDE_MM // _LEG_MM)
    crawl.long_stride = crawl.stride * 3 // 2
    crawl.half_length = length // 2
    crawl.half_width = abs(front.hip.y + front.hip_length)
    bends = [_bend(params.legs[leg]) for leg in range(LEGS)]
    straight = min(32767, *(far for far, _ in bends))
    feeling = min(straight, *(bent_length(params.legs[leg], _LEAST_BEND) for leg in range(LEGS)))
    crawl.height = straight * 173 // 200
    for name in ("body_acceleration", "quick_body_acceleration"):
        setattr(crawl, name, getattr(crawl, name) * params.leg_length * _HEIGHT_MM // (crawl.height * _LEG_MM))
    crawl.reach = feeling - feeling // 49
    crawl.swing_reach = feeling - feeling // 240
    crawl.folded = max(near + near // 72 for _, near in bends)


def _calm(params: Params, robot: Robot) -> None:
    """Lower the gains of the pose loop where the body sways on: in the proportion in which its drives damp it less.

    Three legs whose drives damp by D carry a mass m at a height h, whose sway is damped by d = 3 D / (m h^2). An
    integral of 1 / 333 ms is stable only below d (Routh), and the loop's delay takes some of that.
    """
    height_m = params.crawl.height / (1 << params.length_shift)
    damping = 3 * joint_drives(robot)[THIGH].damping_Nms_rad / (robot.mass_kg * height_m**2)
    for name in ("error_q15", "integral_q15"):
        setattr(params.crawl, name, round(getattr(params.crawl, name) * min(1.0, damping / _CALM_1_S)))


def _feel(params: Params, robot: Robot) -> None:
    """Fit the least loads of a contact to the joints' friction, which looks like load: half to one and a half."""
    coulomb_Nm = sum(joint.coulomb_Nm for joint in joint_drives(robot)[THIGH : CALF + 1]) / 2
    weight_Nm = robot.mass_kg * GRAVITY_M_S2 * robot.geometry.leg_m / 2
    share = max(0.5, min(1.5, coulomb_Nm / weight_Nm / _FRICTION_SHARE))
    for name in ("touch_q12", "peak_q12"):
        setattr(params.crawl, name, round(getattr(params.crawl, name) * share))


def _soften(params: Params, robot: Robot) -> None:
    """Lower the feet no faster to even ground than that a step there would be pushed at by 0.7 of the weight.

    The foot is told to go on for the lag of its goals, and slowly until the contact is sure; ``push_N_m`` is the
    stiffness there of a leg whose thigh lies level.
    """
    crawl, unit_m = params.crawl, 2.0**-params.length_shift
    push_N_m = joint_drives(robot)[THIGH].stiffness_Nm_rad / (robot.geometry.leg_m / 2) ** 2
    deep_lf = _MOST_PUSH * robot.mass_kg * GRAVITY_M_S2 / push_N_m / unit_m * (1 << LF_BITS)
    most = int(deep_lf - crawl.loaded_lower_speed * crawl.contact_ticks) // crawl.goal_lag_ticks
    crawl.quick_lower_speed = max(crawl.unknown_lower_speed, min(crawl.quick_lower_speed, most))


def _steady(params: Params, robot: Robot) -> None:
    """Lower the feet no faster than that a body leans by 0.04 of the leg over a foot that meets ground unexpectedly.

    The foot is told to go on as in ``_soften``, and lifts its corner of the body by that, less what the leg gives under
    half of the weight; the body's middle goes aside by height over width as much. ``push_N_m`` is the stiffness of a
    leg whose foot is below its hip: the calf's alone, whose lever is the distance of the knee from the line between.
    """
    crawl, unit_m = params.crawl, 2.0**-params.length_shift
    height_m, width_m, leg_m = crawl.height * unit_m, 2 * crawl.half_width * unit_m, robot.geometry.leg_m
    push_N_m = joint_drives(robot)[CALF].stiffness_Nm_rad / ((leg_m / 2) ** 2 - (height_m / 2) ** 2)
    most_m = robot.mass_kg * GRAVITY_M_S2 / 2 / push_N_m + _MOST_LEAN * leg_m * width_m / height_m
    deep_lf = crawl.unknown_lower_speed * crawl.goal_lag_ticks + crawl.loaded_lower_speed * crawl.contact_ticks
    share = min(1.0, most_m / (deep_lf * unit_m / (1 << LF_BITS)))
    for name in ("loaded_lower_speed", "unknown_lower_speed", "known_lower_speed", "quick_lower_speed"):
        setattr(crawl, name, max(1, round(share * getattr(crawl, name))))


def _bend(leg: Leg) -> tuple[int, int]:
    """Reduce a leg's reach to where the calf's limits end; return its longest and shortest in its plane, lu."""
    straight, bent = (leg.highest.calf, leg.lowest.calf) if leg.knee < 0 else (leg.lowest.calf, leg.highest.calf)
    far, near = bent_length(leg, straight), bent_length(leg, bent)
    leg.longest = min(hypot(far, leg.hip_length), leg.longest)
    leg.shortest = max(hypot(near, leg.hip_length) + 1, leg.shortest)
    leg.clearance = -(leg.shortest + abs(leg.hip_length) >> 1)
    return far, near


def bent_length(leg: Leg, calf_brad: int) -> int:
    """Return thigh joint to foot in lu of a leg bent by ``calf_brad``: L2^2 + L3^2 + 2 L2 L3 cos q3, within 4 lu."""
    l2, l3 = leg.thigh_length, leg.calf_length
    return 2 * isqrt((l2 * l2 >> 2) + (l3 * l3 >> 2) + ((l2 * l3 >> 15) * cos_q15(calf_brad) >> 1))
