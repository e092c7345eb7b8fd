"""Fixed-point primitives: saturation, rounding products, sine, arctangent, square root.

Angles are binary fractions of a turn: ``_brad`` is 1/65536 turn and wraps with ``& 0xFFFF``;
``_brad18`` is 1/262144 turn, used where results are still to be added. Every intermediate stays
within -2^30 .. 2^30-1 for the stated ranges, so nothing here is ever a heap object on a 32-bit
MicroPython. The errors in the docstrings are worst cases, checked in tests/shared/test_fixed.py.
"""

from ..runtime import Ints, const, hot
from .tables import ATAN_LINES, SINE_LINES, SQRT_SEED

_QUARTER = const(512)  # of a turn, in the sine's table
_EIGHTH_BRAD18 = const(0x8000)
_QUARTER_BRAD18 = const(0x10000)
_HALF_BRAD18 = const(0x20000)
_RATIO_MOST = const(0x3FFFFFFF)


@hot
def saturate(value: int, low: int, high: int) -> int:
    """Return ``value`` limited to ``low .. high`` (any unit; low <= high). Exact."""
    if value < low:
        return low
    if value > high:
        return high
    return value


@hot
def mul_q15(a: int, b_q15: int) -> int:
    """Return a * b / 2^15 rounded to nearest, halves upwards.

    Range: \\|a * b\\| <= 2^30 - 2^15, so a and b both within +-32767 is always allowed.
    Error at most 1/2 unit of ``a``.
    """
    return (a * b_q15 + 0x4000) >> 15


@hot
def sin_q15(angle_brad: int) -> int:
    """Return the sine in Q15, -32767 .. 32767, of any angle in 1/65536 turn.

    A line in each of 1024 steps of the turn (host/boards/build/tables.py). Error at most 1 LSB of Q15. Largest
    intermediate 2^22.
    """
    lines = SINE_LINES
    at = angle_brad >> 5 & 2046
    return lines[at] + lines[at + 1] * (angle_brad & 63) >> 7


@hot
def cos_q15(angle_brad: int) -> int:
    """Return the cosine in Q15, -32767 .. 32767, of any angle in 1/65536 turn. Error as sin_q15.

    It is sin_q15 a quarter turn on.
    """
    lines = SINE_LINES
    at = (angle_brad >> 5) + _QUARTER & 2046
    return lines[at] + lines[at + 1] * (angle_brad & 63) >> 7


@hot
def atan2_brad18(y: int, x: int) -> int:
    """Return the angle of (x, y) in 1/2^18 turn, -131072 .. 131071; (0, 0) gives 0.

    Range: both within +-(2^30 - 1), in any common unit. Error at most 0.0025 deg = 1.8 units.
    The ratio of the smaller to the larger side is formed in 18 bits by two divisions, so that the larger may keep 18
    to 21 bits; then arctan by a table, linear between. Largest: the smaller side, below 2^21, times 2^9: below 2^30.
    """
    lines = ATAN_LINES
    far = x
    if far < 0:
        far = -far
    near = y
    if near < 0:
        near = -near
    steep = 0
    if near > far:
        far, near = near, far
        steep = 1
    if far == 0:
        return 0
    if far < 0x200000:
        while far < 0x20000:
            far, near = far * 16, near * 16
    elif far >= 0x4000000:
        far, near = ((far >> 1) + 128) >> 8, ((near >> 1) + 128) >> 8
    elif far >= 0x800000:
        far, near = (far + 16) >> 5, (near + 16) >> 5
    else:
        far, near = (far + 2) >> 2, (near + 2) >> 2
    angle = _EIGHTH_BRAD18
    if near != far:
        near *= 512
        high = near // far
        ratio = high * 512 + (near - high * far) * 512 // far
        line = ratio >> 9 & 510
        angle = lines[line] + lines[line + 1] * (ratio & 1023) >> 10
    if steep:
        angle = _QUARTER_BRAD18 - angle
    if x < 0:
        angle = _HALF_BRAD18 - angle
    if y < 0 or angle == _HALF_BRAD18:
        return -angle
    return angle


@hot
def round_brad(angle_brad18: int) -> int:
    """Return an angle in 1/65536 turn, wrapped to -32768 .. 32767, from one in 1/2^18 turn.

    Range: any within +-(2^30 - 4). Rounds to nearest: error at most 1/2 unit.
    """
    return (((angle_brad18 + 2) >> 2) + 0x8000 & 0xFFFF) - 0x8000


@hot
def wrap_brad(angle_brad: int) -> int:
    """Return an angle in 1/65536 turn, any within +-2^29, wrapped to -32768 .. 32767. Exact."""
    return (angle_brad + 0x8000 & 0xFFFF) - 0x8000


@hot
def atan2_brad(y: int, x: int) -> int:
    """Return the angle of (x, y) in 1/65536 turn, -32768 .. 32767; (0, 0) gives 0.

    Range: both within +-(2^30 - 1). Error at most 0.0025 deg before the rounding to 0.0055 deg.
    """
    return round_brad(atan2_brad18(y, x))


@hot
def isqrt(n: int) -> int:
    """Return floor(sqrt(n)), exact for 0 .. 2^30 - 1; 0 for a negative n.

    n is scaled to [2^28, 2^30) by an even shift; a table gives a root that is never too small
    and at most 1/64 too large; one Newton step from above leaves it 0 .. 2 too large, which the
    closing loop takes back. Largest intermediate 32768 * 32767 < 2^30.
    """
    if n <= 0:
        return 0
    table = SQRT_SEED
    scaled = n
    shift = 0
    if scaled < 0x4000000:
        if scaled < 0x4000:
            scaled <<= 16
            shift = 8
        if scaled < 0x400000:
            scaled <<= 8
            shift += 4
        if scaled < 0x4000000:
            scaled <<= 4
            shift += 2
    if scaled < 0x10000000:
        scaled <<= 2
        shift += 1
    root = table[(scaled >> 22) - 64]
    root = (root + scaled // root) >> 1
    root >>= shift
    while root * root > n:
        root -= 1
    return root


@hot
def round_sqrt(n: int) -> int:
    """Return sqrt(n) rounded to nearest for 0 .. 2^30 - 1; 0 for a negative n. Error at most 1/2."""
    root = isqrt(n)
    if n - root * root > root:
        return root + 1
    return root


@hot
def hypot(x: int, y: int) -> int:
    """Return floor(sqrt(x^2 + y^2)) for x and y within +-(2^29 - 1).

    Exact while x^2 + y^2 < 2^30; above that both sides are first shifted down together, and the
    error stays below 2^-13 of the result.
    """
    if x < 0:
        x = -x
    if y < 0:
        y = -y
    shift = 0
    while x > 32767 or y > 32767 or (x * x >> 2) + (y * y >> 2) >= 0x0FFFFFFF:
        x = (x + 1) >> 1
        y = (y + 1) >> 1
        shift += 1
    return isqrt(x * x + y * y) << shift


@hot
def ratio(numerator: int, denominator: int, bits: int) -> int:
    """Return floor(numerator 2^bits / denominator), at most 2^30 - 1; 0 if numerator < 0 or denominator < 1.

    numerator 0 .. 2^30 - 1, denominator 1 .. 2^29, bits 0 .. 30. Exact: divides bit by bit.
    """
    if numerator < 0 or denominator < 1:
        return 0
    result = numerator // denominator
    rest = numerator - result * denominator
    for _ in range(bits):
        if result > _RATIO_MOST >> 1:
            return _RATIO_MOST
        result += result
        rest += rest
        if rest >= denominator:
            rest -= denominator
            result += 1
    return result


@hot
def fall_q15(value: int, start: int, end: int) -> int:
    """Return 32768 at ``start`` and before, 0 at ``end`` and beyond, linear between; falling or rising.

    All within +-32767, start and end at most that far apart. start = end is a step: 0 from there on. Error at most 1.
    """
    span = end - start
    left = end - value
    if span < 0:
        span = -span
        left = -left
    if left <= 0:
        return 0
    if left >= span:
        return 0x8000
    return (left << 15) // span


@hot
def round_roots(squares: Ints, roots: Ints, count: int) -> None:
    """Write the roots of ``count`` numbers, rounded to nearest, 0 for negative ones. Each as round_sqrt."""
    table = SQRT_SEED
    for at in range(count):
        n = squares[at]
        root = 0
        if n > 0:
            scaled = n
            shift = 15
            while scaled < 0x10000000:
                scaled <<= 2
                shift -= 1
            root = table[(scaled >> 22) - 64]
            root = (root + scaled // root) >> 1
            root >>= 15 - shift
            while root * root > n:
                root -= 1
            if n - root * root > root:
                root += 1
        roots[at] = root


@hot
def arctans_brad18(ys: Ints, xs: Ints, angles: Ints, count: int) -> None:
    """Write the angles of ``count`` points (x, y) in 1/2^18 turn. Each as atan2_brad18."""
    lines = ATAN_LINES
    for at in range(count):
        far = xs[at]
        near = ys[at]
        turned = 0
        if far < 0:
            far = -far
            turned = 1
        if near < 0:
            near = -near
            turned += 2
        if near > far:
            far, near = near, far
            turned += 4
        if far >= 0x4000000:  # three of the turns below at once
            far = (far >> 1) + 21 >> 5
            near = (near >> 1) + 21 >> 5
        while far >= 0x200000:
            far = (far >> 1) + 1 >> 1
            near = (near >> 1) + 1 >> 1
        while far < 0x20000 and far > 0:
            far <<= 4
            near <<= 4
        angle = 0
        if near == far and far > 0:
            angle = _EIGHTH_BRAD18
        elif far > 0:
            near <<= 9
            high = near // far
            ratio = (high << 9) + ((near - high * far) << 9) // far
            line = ratio >> 9 & 510
            angle = lines[line] + lines[line + 1] * (ratio & 1023) >> 10
        if turned & 4:
            angle = _QUARTER_BRAD18 - angle
        if turned & 1:
            angle = _HALF_BRAD18 - angle
        if turned & 2:
            angle = -angle
        elif angle == _HALF_BRAD18:
            angle = -_HALF_BRAD18
        angles[at] = angle
