"""All four legs at once: forward and inverse kinematics with few calls, as a fast tick needs them.

The same leg as in leg.py, but the sines, roots and arctangents of all legs are computed in one loop each: a call costs
as much as three of them.
"""

from ..num.fixed import arctans_brad18, round_roots
from ..num.tables import SINE_LINES
from ..runtime import Ints, const, hot, zeros
from .feet import Feet
from .params import CALF, JOINTS, LEGS, THIGH, Params
from .reach import reach_foot


class LegsWork:
    """What one loop hands to the next; nothing in it lasts beyond a tick."""

    def __init__(self) -> None:
        self.waves = zeros(2 * JOINTS)  # Q15: sines of hip, thigh and thigh + calf of each leg, then their cosines
        self.squares = zeros(2 * LEGS)  # lu^2: arguments of the roots
        self.roots = zeros(2 * LEGS)  # lu
        self.drops = zeros(LEGS)  # lu: a of leg.py, hip axis to foot in the leg's plane
        self.lengths = zeros(LEGS)  # lu^2: thigh joint to foot
        self.rises = zeros(4 * LEGS)  # y of the arctangents' arguments: three joints a leg, then the leads
        self.runs = zeros(4 * LEGS)  # x of the arguments
        self.turns = zeros(4 * LEGS)  # the arctangents, 2^-18 turn


_QUARTER = const(512)  # of a turn, in the sine's table
_HALF = const(0x8000)


@hot
def legs_waves(joints: Ints, waves: Ints) -> None:
    """Write sines and cosines, Q15, of hip, thigh and thigh + calf of 12 joints in brad.

    Each as sin_q15 and cos_q15.
    """
    lines = SINE_LINES
    calf = 2
    for joint in range(JOINTS):
        angle = joints[joint]
        if joint == calf:
            angle += joints[joint - 1]
            calf += 3
        rest = angle & 63
        at = angle >> 5 & 2046
        waves[joint] = lines[at] + lines[at + 1] * rest >> 7
        at = at + _QUARTER & 2046
        waves[joint + JOINTS] = lines[at] + lines[at + 1] * rest >> 7


@hot
def legs_forward(params: Params, joints: Ints, waves: Ints, feet: Feet) -> None:
    """Write the four feet in the body, lu, for 12 joints in brad (any value).

    ``waves`` gets what legs_waves makes of the joints. Error as leg_forward. Intermediates below 32767 * 32767 + 2^14.
    """
    legs_waves(joints, waves)
    at = 0
    for leg in range(LEGS):
        limb = params.legs[leg]
        foot = feet.legs[leg]
        upper = limb.thigh_length
        lower = limb.calf_length
        side = limb.hip_length
        sine = waves[at]
        cosine = waves[at + JOINTS]
        drop = (upper * waves[at + JOINTS + THIGH] + 0x4000 >> 15) + (lower * waves[at + JOINTS + CALF] + 0x4000 >> 15)
        ahead = (upper * waves[at + THIGH] + 0x4000 >> 15) + (lower * waves[at + CALF] + 0x4000 >> 15)
        foot.x = limb.hip.x - ahead
        foot.y = limb.hip.y + (side * cosine + 0x4000 >> 15) + (drop * sine + 0x4000 >> 15)
        foot.z = limb.hip.z + (side * sine + 0x4000 >> 15) - (drop * cosine + 0x4000 >> 15)
        at += 3


@hot
def legs_inverse(params: Params, hip_feet: Feet, work: LegsWork, joints: Ints) -> int:
    """Write 12 joints in brad for the feet in ``hip_feet``, lu from the hips; return the flags of moved feet, or 0.

    A foot out of reach is first brought into it, in ``hip_feet`` (reach.py). Error and intermediates as leg_inverse.
    """
    squares = work.squares
    flags = reach_feet(params, hip_feet, work.squares)
    round_roots(work.squares, work.drops, LEGS)
    for leg in range(LEGS):
        limb = params.legs[leg]
        x = hip_feet.legs[leg].x
        length_sq = x * x
        if squares[leg] > 0:
            length_sq += squares[leg]
        work.lengths[leg] = length_sq
        squares[leg + LEGS] = length_sq - limb.inner_sq
        squares[leg] = limb.outer_sq - length_sq
    round_roots(work.squares, work.roots, 2 * LEGS)
    fill_turns(params, hip_feet, work)
    finish_turns(params, work, joints)
    return flags


@hot
def reach_feet(params: Params, hip_feet: Feet, squares: Ints) -> int:
    """Bring the feet of ``hip_feet``, lu from the hips, into reach (reach.py); return the flags of moved feet, or 0.

    Feet that are certainly within reach skip the full check. Writes a^2 of leg.py for each leg, lu^2, into ``squares``.
    Part of legs_inverse.
    """
    flags = 0
    for leg in range(LEGS):
        limb = params.legs[leg]
        foot = hip_feet.legs[leg]
        x = foot.x
        y = foot.y
        z = foot.z
        side = limb.hip_length
        sure = 0
        if x <= 32767 and x >= -32767 and y <= 32767 and y >= -32767 and z <= 32767 and z >= -32767:
            across = (y * y >> 2) + (z * z >> 2)
            quarter = across + (x * x >> 2)
            if across >= (side * side >> 2) + 2 and quarter <= limb.longest * limb.longest >> 2 and (
                quarter >= (limb.shortest * limb.shortest >> 2) + 2
            ):
                sure = 1
        if sure == 0:
            flags |= reach_foot(params, leg, hip_feet, hip_feet)
            y = foot.y
            z = foot.z
        squares[leg] = y * y + z * z - side * side
    return flags


@hot
def fill_turns(params: Params, hip_feet: Feet, work: LegsWork) -> None:
    """Write the arguments of the joints' arctangents, and compute these. Part of legs_inverse.

    Hip: one arctangent, of the product of two complex numbers. Thigh: the direction of the foot. Calf: half of its
    bend. The thigh's lead before the foot's direction is half of the bend too if thigh and calf are equally long.
    """
    roots = work.roots
    rises = work.rises
    runs = work.runs
    count = 3 * LEGS
    at = 0
    for leg in range(LEGS):
        limb = params.legs[leg]
        foot = hip_feet.legs[leg]
        drop = work.drops[leg]
        y = foot.y
        z = foot.z
        side = limb.hip_length
        rises[at] = y * drop + z * side
        runs[at] = y * side - z * drop
        rises[at + THIGH] = foot.x
        runs[at + THIGH] = drop
        rises[at + CALF] = roots[leg]
        runs[at + CALF] = roots[leg + LEGS]
        if limb.half_diff:
            count = 4 * LEGS
            rises[leg + 3 * LEGS] = roots[leg] * roots[leg + LEGS] >> 1
            runs[leg + 3 * LEGS] = (work.lengths[leg] >> 1) + limb.half_diff
        at += 3
    arctans_brad18(work.rises, work.runs, work.turns, count)


@hot
def finish_turns(params: Params, work: LegsWork, joints: Ints) -> None:
    """Write the joints from the arctangents. Part of legs_inverse."""
    turns = work.turns
    at = 0
    for leg in range(LEGS):
        limb = params.legs[leg]
        bend = turns[at + CALF] << 1
        lead = turns[at + CALF]
        if limb.half_diff:
            lead = turns[leg + 3 * LEGS]
        if limb.knee < 0:
            bend = -bend
            lead = -lead
        joints[at] = ((turns[at] + 2 >> 2) + _HALF & 0xFFFF) - _HALF
        joints[at + THIGH] = ((2 - turns[at + THIGH] - lead >> 2) + _HALF & 0xFFFF) - _HALF
        joints[at + CALF] = ((bend + 2 >> 2) + _HALF & 0xFFFF) - _HALF
        at += 3
