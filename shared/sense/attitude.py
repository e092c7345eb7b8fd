"""Roll and pitch from raw gyroscope and accelerometer counts (MPU6050 registers, int16).

A complementary filter on the direction of gravity. The gyroscope turns the vector. The accelerometer pulls it back,
only while it reads close to 1 g, and slowly: a filter as fast as a walking body sways and lands would report a slope
that is not there. A correction that persists is the gyroscope's bias, which changes as the chip warms. At rest the
accelerometer shows gravity alone and the gyroscope its bias alone, and both are soon trusted. No angle is integrated,
so nothing wraps and no pose is singular. Angles come out as R = Rx(roll) Ry(pitch): the body's own tilt, as
shared/body/pose.py commands it.

MPU6050 scales (register map, sections 4.17 and 4.19): +-2 g = 16384 counts a g, +-250 deg/s = 131 counts a deg/s; the
other ranges only change the gains in the attitude.
"""

from ..body.axes import Point, Turn
from ..num.fixed import atan2_brad, hypot, isqrt, saturate
from ..record import field, part, record, vector
from ..runtime import Ints, const, hot


@record
class Attitude:
    """The filter of one sensor: settings (filled in by the host), state, and the angles that result."""

    gyro_q30: int = field("rad / (count tick) Q30", "the gyroscope's scale (1/131 deg/s at 50 Hz: 2862)")
    one_g: int = field("counts", "the accelerometer at 1 g, 2048 .. 16384")
    trust_q15: int = field("Q15", "share of the accelerometer's correction per tick")
    learn_q12: int = field("counts Q16 / rad Q14 Q12", "change of the gyroscope's bias per tick and correction")
    tolerance: int = field("counts", "distance from 1 g beyond which the accelerometer is not believed")
    align_ticks: int = field("ticks", "readings at rest that start-up averages, 1 .. 1024")
    bias: Ints = vector(3, "counts Q16", "the gyroscope's bias, within 2^29")
    gravity: Point = part(Point, "direction of 'up' in the body, Q22")
    gathered: int = field("ticks", "readings that start-up has gathered so far")
    sum: Ints = vector(3, "counts", "sum of the accelerometer's readings at start-up")
    gyro_sum: Ints = vector(3, "counts", "sum of the gyroscope's readings at start-up")
    rest_change: Ints = vector(2, "counts", "largest at rest, of the gyroscope's and the accelerometer's readings")
    rest_reading: Ints = vector(6, "counts", "the reading with which the present rest began")
    rest_ticks: int = field("ticks", "for how long the sensor has been at rest, up to align_ticks")
    rejected_ticks: int = field("ticks", "for how long the accelerometer has not been believed")
    roll: int = field("brad", "the result")
    pitch: int = field("brad", "the result")
    remainder_q27: Ints = vector(3, "rad Q27", "remainder of each axis's turn, for the next tick")
    turned: Turn = part(Turn, "turn in the last tick")


ALIGNING = const(1)  # attitude_step flags
ACCEL_REJECTED = const(2)
MOVED_WHILE_ALIGNING = const(4)

_ONE_Q22 = const(0x400000)
_STILL_COUNTS = const(1310)  # 10 deg/s at 131 counts: more means the robot is being moved (assumed)
_REST_SHIFT = const(3)  # at rest the sensors are trusted 2^3 times as fast (chosen: in 0.6 s where trust_time is 5 s)
_MISSED_MAX = const(1024)  # rad Q14, 3.6 deg: an error beyond it is from a knock or a fall, not from a bias
_OFF_MAX_Q6 = const(16383)  # 256 counts: a bias that is further off is corrected bit by bit
_BIAS_MAX = const(0x1FFFFFFF)  # counts Q16: 62 deg/s; an MPU6050 has up to 20 (specification 3.4, 6.1)


@hot
def attitude_reset(attitude: Attitude) -> None:
    """Start again with the alignment at rest; settings stay."""
    attitude.gathered = 0
    for axis in range(3):
        attitude.sum[axis] = 0
        attitude.gyro_sum[axis] = 0
        attitude.gravity[axis] = 0
        attitude.remainder_q27[axis] = 0
        attitude.turned[axis] = 0
    attitude.gravity.z = _ONE_Q22
    attitude.rejected_ticks = 0
    attitude.rest_ticks = 0
    attitude.roll = 0
    attitude.pitch = 0


@hot
def attitude_step(attitude: Attitude, gyro_accel: Ints) -> int:
    """Take one reading and update ``attitude.roll`` and ``attitude.pitch``; return flags.

    gyro_accel: 6 int16 counts, gyro x y z then accelerometer x y z, body axes (x forward, y left,
    z up; accelerometer +1 g on z at rest). The first ``attitude.align_ticks`` readings are averaged into the
    start attitude and the gyro bias (ALIGNING; MOVED_WHILE_ALIGNING starts again). After that
    ACCEL_REJECTED marks a reading away from 1 g. Angles within 0.05 deg of a float filter of the
    same law. All intermediates below 2^30 for any int16 input.
    """
    if attitude.gathered < attitude.align_ticks:
        return align(attitude, gyro_accel)
    turn(attitude, gyro_accel)
    flags = pull(attitude, gyro_accel)
    angles(attitude)
    return flags


@hot
def align(attitude: Attitude, gyro_accel: Ints) -> int:
    """Add one reading at rest to the start-up averages; the last one sets attitude and bias."""
    rest_ticks = count_rest(attitude, gyro_accel)
    for axis in range(3):
        rate = gyro_accel[axis]
        if rate > _STILL_COUNTS or rate < -_STILL_COUNTS or rest_ticks < attitude.gathered:
            attitude_reset(attitude)
            return ALIGNING | MOVED_WHILE_ALIGNING
        attitude.gyro_sum[axis] += rate
        attitude.sum[axis] += gyro_accel[axis + 3]
    attitude.gathered += 1
    if attitude.gathered < attitude.align_ticks:
        return ALIGNING
    for axis in range(3):
        attitude.bias[axis] = (attitude.gyro_sum[axis] << 8) // attitude.gathered << 8
        attitude.sum[axis] = attitude.sum[axis] // attitude.gathered
    size = size_of(attitude.sum[0], attitude.sum[1], attitude.sum[2])
    if not near_one_g(attitude, size):
        attitude_reset(attitude)
        return ALIGNING | ACCEL_REJECTED
    for axis in range(3):
        attitude.gravity[axis] = (attitude.sum[axis] << 14) // size << 8
    angles(attitude)
    return ALIGNING


@hot
def size_of(x: int, y: int, z: int) -> int:
    """Return the length of a vector of int16 counts, floor, within 2^-12."""
    return hypot(hypot(x, y), z)


@hot
def near_one_g(attitude: Attitude, size: int) -> int:
    """Return 1 if an accelerometer reading of this length is close enough to 1 g, else 0."""
    away = size - attitude.one_g
    if size < 1 or away > attitude.tolerance or away < -attitude.tolerance:
        return 0
    return 1


@hot
def rate_q18(attitude: Attitude, counts: int, axis: int) -> int:
    """Return the turn about ``axis`` during one tick in 2^-18 rad, limited to +-1/8 rad.

    counts: int16. 1/8 rad a tick is 358 deg/s at 50 Hz; beyond it the attitude lags and the accelerometer brings it
    back. The remainder below one unit is kept for the next tick: at 500 Hz a unit is 0.11 deg/s. Intermediates:
    8192 * 131071 + 511 < 2^30.
    """
    fine = saturate((counts << 6) - (attitude.bias[axis] >> 10), -0x3FFFFF, 0x3FFFFF)
    gain = saturate(attitude.gyro_q30, 0, 0x1FFFF)
    turned_q27 = (fine >> 9) * gain + ((fine & 511) * gain >> 9) + attitude.remainder_q27[axis]
    attitude.remainder_q27[axis] = turned_q27 & 511
    return saturate(turned_q27 >> 9, -0x8000, 0x8000)


@hot
def turn(attitude: Attitude, gyro_accel: Ints) -> None:
    """Turn the gravity vector by one tick of gyro: g += g x w, midpoint by two half steps."""
    wx = rate_q18(attitude, gyro_accel[0], 0)
    wy = rate_q18(attitude, gyro_accel[1], 1)
    wz = rate_q18(attitude, gyro_accel[2], 2)
    attitude.turned.x = wx
    attitude.turned.y = wy
    attitude.turned.z = wz
    x = attitude.gravity.x
    y = attitude.gravity.y
    z = attitude.gravity.z
    mx = x + (cross(y, z, wy, wz) >> 1)
    my = y + (cross(z, x, wz, wx) >> 1)
    mz = z + (cross(x, y, wx, wy) >> 1)
    attitude.gravity.x = x + cross(my, mz, wy, wz)
    attitude.gravity.y = y + cross(mz, mx, wz, wx)
    attitude.gravity.z = z + cross(mx, my, wx, wy)


@hot
def cross(b_q22: int, c_q22: int, wb_q18: int, wc_q18: int) -> int:
    """Return b * wc - c * wb in Q22: one component of g x w.

    Range: vector components within +-2^23, rates within +-2^15. The vector is taken in Q14 for
    the product's upper part and its lower byte apart: products below 2^15 * 2^15.
    """
    upper = (b_q22 >> 8) * wc_q18 - (c_q22 >> 8) * wb_q18
    lower = (b_q22 & 255) * wc_q18 - (c_q22 & 255) * wb_q18
    return (upper + (lower >> 8) + 0x200) >> 10


@hot
def pull(attitude: Attitude, gyro_accel: Ints) -> int:
    """Pull the gravity vector towards the accelerometer if that reads about 1 g; return flags."""
    size = size_of(gyro_accel[3], gyro_accel[4], gyro_accel[5])
    if not near_one_g(attitude, size):
        attitude.rejected_ticks = saturate(attitude.rejected_ticks + 1, 0, 0xFFFF)
        attitude.rest_ticks = 0
        normalise(attitude)
        return ACCEL_REJECTED
    attitude.rejected_ticks = 0
    x = (gyro_accel[3] << 14) // size
    y = (gyro_accel[4] << 14) // size
    z = (gyro_accel[5] << 14) // size
    trust_q15 = attitude.trust_q15
    if count_rest(attitude, gyro_accel) == attitude.align_ticks:
        trust_q15 = saturate(trust_q15 << _REST_SHIFT, 0, 32767)
        for axis in range(3):
            off_q6 = saturate((gyro_accel[axis] << 6) - (attitude.bias[axis] >> 10), -_OFF_MAX_Q6, _OFF_MAX_Q6)
            set_bias(attitude, axis, attitude.bias[axis] + (off_q6 * trust_q15 >> 5))
    else:
        learn_bias(attitude, x, y, z)
    pull_axis(attitude, 0, x, trust_q15)
    pull_axis(attitude, 1, y, trust_q15)
    pull_axis(attitude, 2, z, trust_q15)
    normalise(attitude)
    return 0


@hot
def count_rest(attitude: Attitude, gyro_accel: Ints) -> int:
    """Count for how many ticks the readings have not changed, up to align_ticks; return that."""
    attitude.rest_ticks = saturate(attitude.rest_ticks + 1, 0, attitude.align_ticks)
    for at in range(6):
        change = gyro_accel[at] - attitude.rest_reading[at]
        most = attitude.rest_change[at // 3]
        if change > most or change < -most:
            attitude.rest_ticks = 0
    if attitude.rest_ticks == 0:
        for at in range(6):
            attitude.rest_reading[at] = gyro_accel[at]
    return attitude.rest_ticks


@hot
def pull_axis(attitude: Attitude, axis: int, seen_q14: int, trust_q15: int) -> None:
    """Pull one component of the gravity vector by a share towards the accelerometer's."""
    off_q14 = seen_q14 - (attitude.gravity[axis] >> 8)
    attitude.gravity[axis] += off_q14 * trust_q15 >> 7


@hot
def learn_bias(attitude: Attitude, x_q14: int, y_q14: int, z_q14: int) -> None:
    """Correct the gyroscope's bias by the turn that is missing from the gravity vector to the accelerometer's.

    A turn about the vertical changes neither: the bias about it stays as it was at rest. Intermediates: 2^29.
    """
    x = attitude.gravity.x >> 8
    y = attitude.gravity.y >> 8
    z = attitude.gravity.z >> 8
    learn_axis(attitude, 0, y_q14 * z - z_q14 * y)
    learn_axis(attitude, 1, z_q14 * x - x_q14 * z)
    learn_axis(attitude, 2, x_q14 * y - y_q14 * x)


@hot
def learn_axis(attitude: Attitude, axis: int, missed_q28: int) -> None:
    """Correct one axis's bias by a share of the missing turn."""
    missed = saturate(missed_q28 >> 14, -_MISSED_MAX, _MISSED_MAX)
    learnt = missed * saturate(attitude.learn_q12, 0, 0x3FFFF) >> 12
    set_bias(attitude, axis, attitude.bias[axis] - learnt)


@hot
def set_bias(attitude: Attitude, axis: int, bias_q16: int) -> None:
    """Set one axis's bias, limited."""
    attitude.bias[axis] = saturate(bias_q16, -_BIAS_MAX, _BIAS_MAX)


@hot
def normalise(attitude: Attitude) -> None:
    """Scale the gravity vector to length 1 in Q22, unless it is too short to have a direction.

    The length is taken from Q14 parts, and an error within 2^-11 is left: the result is within 2^-10 of 1.
    """
    x = attitude.gravity.x >> 8
    y = attitude.gravity.y >> 8
    z = attitude.gravity.z >> 8
    size_sq = x * x + y * y + z * z
    if size_sq < 0x100000:
        return
    short = 0x4000 - isqrt(size_sq)
    if short > 8 or short < -8:
        if short < -0x4000 or short > 0x2000:
            short = saturate(short, -0x4000, 0x2000)
        for axis in range(3):
            part = attitude.gravity[axis]
            attitude.gravity[axis] = part + ((part >> 8) * short >> 6)


@hot
def angles(attitude: Attitude) -> None:
    """Write roll and pitch of the gravity vector: up in the body is (-ca sb, sa, ca cb).

    Roll lies within +-90 deg, pitch within +-180 deg: a robot on its back reads as pitched over.
    """
    x = attitude.gravity.x >> 7
    y = attitude.gravity.y >> 7
    z = attitude.gravity.z >> 7
    attitude.pitch = atan2_brad(-x, z)
    attitude.roll = atan2_brad(y, hypot(x, z))
