"""Which foot carries how much: the robot's weight shared out over any set of stance feet.

Weighted minimum norm, F_k = w_k (a + b x_k + c y_k) with sum F = W and no moment about the centre of mass: continuous
from four feet (all w = 1) to three (one w going to 0). Two feet, or feet in one line, share the weight as a lever along
that line; no force of theirs can stop the robot from tipping about the line. Forces are Q12 of the robot's own weight,
so 4096 is the bare robot.
"""

from ..num.fixed import saturate
from ..record import field, part, parts, record, vector
from ..runtime import Ints, const, hot
from .axes import Spot
from .feet import Feet
from .params import LEGS


@record
class Load:
    """How the weight is shared out, and the intermediate results."""

    wanted_q12: Ints = vector(LEGS, "own weight Q12", "the share of each foot")
    middle: Spot = part(Spot, "the weighted middle of the feet, lu")
    xx: int = field("(32 lu)^2", "second moment of x with x about that middle, shifted right")
    xy: int = field("(32 lu)^2", "of x with y")
    yy: int = field("(32 lu)^2", "of y with y")
    shift: int = field("bits", "by which the moments are shifted right")
    slope: Spot = part(Spot, "how the share grows along x and y, shifted likewise, Q18 / 32 lu")
    arms: list[Spot] = parts(LEGS, Spot, "each foot that stands, from the middle, 32 lu")


_UNIT_BITS = const(5)  # moments are taken in 32 lu: 10 bits for a leg's length
_UNIT_HALF = const(16)


@hot
def load_share(
    feet: Feet, weights: Ints, com_x: int, com_y: int, weight_q12: int, planar: int, block: Load
) -> int:
    """Write each foot's share of ``weight_q12`` into the block; return 1 if any foot stands, else 0.

    feet: lu in any frame that is level; weights: 4 values, 0 .. 256, how much each foot stands; com_x, com_y: lu in the
    same frame; all within +-32767 lu. weight: 0 .. 16383, Q12 of the own weight. planar: 1 leaves out y, because
    something else holds the roll. No foot pulls: shares are limited to 0 .. weight. Error at most 1 % of the weight
    where four feet span 0.2 of the largest leg or more. Intermediates: 4096 * 16383 + 2^11, and those of load_moments
    and load_slope.
    """
    total = load_moments(feet, weights, planar, block)
    if total <= 0:
        for leg in range(LEGS):
            block.wanted_q12[leg] = 0
        return 0
    load_slope(com_x, com_y, planar, block)
    even = 0x100000 // total
    shift = block.shift + 6
    slope_x = block.slope.x
    slope_y = block.slope.y
    for leg in range(LEGS):
        share = 0
        if weights[leg] > 0:
            arm = block.arms[leg]
            share = even + (slope_x * arm.x + slope_y * arm.y >> shift)
            if share < 0:
                share = 0
            elif share > 0x200000:
                share = 0x200000
            share = share * weights[leg] >> 8
            if share > 4096:
                share = 4096
            share = share * weight_q12 + 2048 >> 12
        block.wanted_q12[leg] = share
    return 1


@hot
def load_moments(feet: Feet, weights: Ints, planar: int, block: Load) -> int:
    """Write the weighted middle of the feet, their arms and second moments about it; return the sum of the weights.

    Arguments as load_share's. The moments are shifted right until xx + yy has 14 bits. Intermediates: 256 * 1023^2. In
    the plane all y are 0.
    """
    total = load_middle(feet, weights, block)
    if total <= 0:
        return 0
    middle_x = block.middle.x
    middle_y = block.middle.y
    xx = 0
    xy = 0
    yy = 0
    for leg in range(LEGS):
        weight = weights[leg]
        if weight > 0:
            foot = feet.legs[leg]
            x = foot.x - middle_x + _UNIT_HALF >> _UNIT_BITS
            if x > 1023 or x < -1023:
                x = saturate(x, -1023, 1023)
            y = 0
            if planar == 0:
                y = foot.y - middle_y + _UNIT_HALF >> _UNIT_BITS
                if y > 1023 or y < -1023:
                    y = saturate(y, -1023, 1023)
            arm = block.arms[leg]
            arm.x = x
            arm.y = y
            xx += x * x * weight >> 8
            xy += x * y * weight >> 8
            yy += y * y * weight >> 8
    shift = 0
    while xx + yy > 16383:
        xx >>= 1
        xy >>= 1
        yy >>= 1
        shift += 1
    block.xx = xx
    block.xy = xy
    block.yy = yy
    block.shift = shift
    return total


@hot
def load_middle(feet: Feet, weights: Ints, block: Load) -> int:
    """Write the weighted middle of the feet, if any stands; return the sum of the weights.

    Intermediates: 2^17 * 256.
    """
    total = 0
    x = 0
    y = 0
    for leg in range(LEGS):
        foot = feet.legs[leg]
        weight = weights[leg]
        total += weight
        x += foot.x * weight
        y += foot.y * weight
    if total > 0:
        block.middle.x = x // total
        block.middle.y = y // total
    return total


@hot
def load_slope(com_x: int, com_y: int, planar: int, block: Load) -> None:
    """Write how the share grows along x and y, so that the force's centre is at the centre of mass.

    Solves the equations of both moments; for feet in one line (determinant below 1/64 of the squared trace) only along
    that line. Slopes are in Q18 per 32 lu, shifted by ``shift``, limited to +-0x3FFFF. Intermediates:
    16383 * 1023 * 2 * 16 < 2^29.
    """
    off_x = saturate(com_x - block.middle.x + _UNIT_HALF >> _UNIT_BITS, -1023, 1023)
    off_y = 0
    if planar == 0:
        off_y = saturate(com_y - block.middle.y + _UNIT_HALF >> _UNIT_BITS, -1023, 1023)
    xx = block.xx
    xy = block.xy
    yy = block.yy
    square = (xx + yy) * (xx + yy)
    det = xx * yy - xy * xy
    if det > square >> 6:
        along_x = yy * off_x - xy * off_y
        along_y = xx * off_y - xy * off_x
    else:
        along_x = xx * off_x + xy * off_y
        along_y = xy * off_x + yy * off_y
        det = square
    det = (det >> 14) + 1
    block.slope.x = saturate((along_x << 4) // det, -0x3FFFF, 0x3FFFF)
    block.slope.y = saturate((along_y << 4) // det, -0x3FFFF, 0x3FFFF)
