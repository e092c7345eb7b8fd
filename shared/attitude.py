"""Roll and pitch from raw gyroscope and accelerometer counts (MPU6050 registers, int16).

A complementary filter on the direction of gravity: the gyro turns the vector, the accelerometer
pulls it back slowly, and only while it reads close to 1 g. No angle is integrated, so nothing
wraps and no pose is singular. Angles come out as R = Rx(roll) Ry(pitch): the body's own tilt,
as shared/body.py commands it.

MPU6050 scales (register map, sections 4.17 and 4.19): +-2 g = 16384 counts a g,
+-250 deg/s = 131 counts a deg/s; the other ranges only change the gains in the block.
"""

from .fixed import atan2_brad, hypot, isqrt, saturate
from .runtime import Ints, const, hot

# Settings, filled by the host
A_GYRO_Q30 = const(0)  # rad per count and tick, Q30 (1/131 deg/s at 50 Hz: 2862)
A_ONE_G = const(1)  # accelerometer counts at 1 g, 2048 .. 16384
A_TRUST_Q15 = const(2)  # share of the accelerometer's correction a tick, 0 .. 32767
A_TOLERANCE = const(3)  # counts away from 1 g beyond which the accelerometer is not believed
A_ALIGN_TICKS = const(4)  # ticks at rest that start-up averages, 1 .. 1024
A_BIAS = const(5)  # 3 values: gyro bias, counts in Q6
# State
A_GRAVITY = const(8)  # 3 values: direction of "up" in the body, Q22
A_COUNT = const(11)  # start-up ticks gathered so far
A_SUM = const(12)  # 3 values: accelerometer sum of start-up
A_GYRO_SUM = const(15)  # 3 values: gyro sum of start-up
A_REJECTED = const(18)  # accelerometer readings in a row that were not believed
# Results
A_ROLL = const(19)  # brad
A_PITCH = const(20)
A_REST_Q27 = const(21)  # state, 3 values: what of each axis's turn was too small for the tick before, rad
ATTITUDE_SIZE = const(24)

ALIGNING = const(1)  # attitude_step flags
ACCEL_REJECTED = const(2)
MOVED_WHILE_ALIGNING = const(4)

_ONE_Q22 = const(0x400000)
_STILL_COUNTS = const(1310)  # 10 deg/s at 131 counts: more means the robot is being moved (assumed)


@hot
def attitude_reset(block: Ints) -> int:
    """Start again with the alignment at rest; settings stay. Returns 0."""
    block[A_COUNT] = 0
    for axis in range(3):
        block[A_SUM + axis] = 0
        block[A_GYRO_SUM + axis] = 0
        block[A_GRAVITY + axis] = 0
        block[A_REST_Q27 + axis] = 0
    block[A_GRAVITY + 2] = _ONE_Q22
    block[A_REJECTED] = 0
    block[A_ROLL] = 0
    block[A_PITCH] = 0
    return 0


@hot
def attitude_step(block: Ints, gyro_accel) -> int:
    """Take one reading and update A_ROLL and A_PITCH; return flags.

    gyro_accel: 6 int16 counts, gyro x y z then accelerometer x y z, body axes (x forward, y left,
    z up; accelerometer +1 g on z at rest). The first A_ALIGN_TICKS readings are averaged into the
    start attitude and the gyro bias (ALIGNING; MOVED_WHILE_ALIGNING starts again). After that
    ACCEL_REJECTED marks a reading away from 1 g. Angles within 0.05 deg of a float filter of the
    same law. All intermediates below 2^30 for any int16 input.
    """
    if block[A_COUNT] < block[A_ALIGN_TICKS]:
        return align(block, gyro_accel)
    turn(block, gyro_accel)
    flags = pull(block, gyro_accel)
    angles(block)
    return flags


@hot
def align(block: Ints, gyro_accel: Ints) -> int:
    """Add one reading at rest to the start-up averages; the last one sets attitude and bias."""
    for axis in range(3):
        rate = gyro_accel[axis]
        if rate > _STILL_COUNTS or rate < -_STILL_COUNTS:
            attitude_reset(block)
            return ALIGNING | MOVED_WHILE_ALIGNING
        block[A_GYRO_SUM + axis] += rate
        block[A_SUM + axis] += gyro_accel[axis + 3]
    block[A_COUNT] += 1
    if block[A_COUNT] < block[A_ALIGN_TICKS]:
        return ALIGNING
    for axis in range(3):
        block[A_BIAS + axis] = (block[A_GYRO_SUM + axis] << 6) // block[A_COUNT]
        block[A_SUM + axis] = block[A_SUM + axis] // block[A_COUNT]
    size = size_of(block[A_SUM], block[A_SUM + 1], block[A_SUM + 2])
    if not believed(block, size):
        attitude_reset(block)
        return ALIGNING | ACCEL_REJECTED
    for axis in range(3):
        block[A_GRAVITY + axis] = (block[A_SUM + axis] << 14) // size << 8
    angles(block)
    return ALIGNING


@hot
def size_of(x: int, y: int, z: int) -> int:
    """Return the length of a vector of int16 counts, floor, within 2^-12."""
    return hypot(hypot(x, y), z)


@hot
def believed(block: Ints, size: int) -> int:
    """Return 1 if an accelerometer reading of this length is close enough to 1 g, else 0."""
    away = size - block[A_ONE_G]
    if size < 1 or away > block[A_TOLERANCE] or away < -block[A_TOLERANCE]:
        return 0
    return 1


@hot
def rate_q18(block: Ints, counts: int, axis: int) -> int:
    """Return the turn about ``axis`` during one tick in 2^-18 rad, limited to +-1/8 rad.

    counts: int16. 1/8 rad a tick is 358 deg/s at 50 Hz; beyond it the attitude lags and the
    accelerometer brings it back. What is smaller than a unit is kept for the next tick: at 500 Hz a
    unit is 0.11 deg/s. Intermediates: 8192 * 131071 + 511 < 2^30.
    """
    fine = saturate((counts << 6) - block[A_BIAS + axis], -0x3FFFFF, 0x3FFFFF)
    gain = saturate(block[A_GYRO_Q30], 0, 0x1FFFF)
    turned_q27 = (fine >> 9) * gain + ((fine & 511) * gain >> 9) + block[A_REST_Q27 + axis]
    block[A_REST_Q27 + axis] = turned_q27 & 511
    return saturate(turned_q27 >> 9, -0x8000, 0x8000)


@hot
def turn(block: Ints, gyro_accel: Ints) -> int:
    """Turn the gravity vector by one tick of gyro: g += g x w, midpoint by two half steps."""
    wx = rate_q18(block, gyro_accel[0], 0)
    wy = rate_q18(block, gyro_accel[1], 1)
    wz = rate_q18(block, gyro_accel[2], 2)
    x = block[A_GRAVITY]
    y = block[A_GRAVITY + 1]
    z = block[A_GRAVITY + 2]
    mx = x + (cross(y, z, wy, wz) >> 1)
    my = y + (cross(z, x, wz, wx) >> 1)
    mz = z + (cross(x, y, wx, wy) >> 1)
    block[A_GRAVITY] = x + cross(my, mz, wy, wz)
    block[A_GRAVITY + 1] = y + cross(mz, mx, wz, wx)
    block[A_GRAVITY + 2] = z + cross(mx, my, wx, wy)
    return 0


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
def pull(block: Ints, gyro_accel: Ints) -> int:
    """Pull the gravity vector towards the accelerometer if that reads about 1 g; return flags."""
    size = size_of(gyro_accel[3], gyro_accel[4], gyro_accel[5])
    if not believed(block, size):
        block[A_REJECTED] = saturate(block[A_REJECTED] + 1, 0, 0xFFFF)
        normalise(block)
        return ACCEL_REJECTED
    block[A_REJECTED] = 0
    trust = block[A_TRUST_Q15]
    for axis in range(3):
        wanted = (gyro_accel[axis + 3] << 14) // size << 8
        block[A_GRAVITY + axis] += ((wanted - block[A_GRAVITY + axis]) >> 8) * trust >> 7
    normalise(block)
    return 0


@hot
def normalise(block: Ints) -> int:
    """Scale the gravity vector to length 1 in Q22; return 0 if it is too short to have a direction.

    Works on Q14 parts for the length and leaves what is within 2^-11, so the result is within 2^-10 of 1.
    """
    x = block[A_GRAVITY] >> 8
    y = block[A_GRAVITY + 1] >> 8
    z = block[A_GRAVITY + 2] >> 8
    size_sq = x * x + y * y + z * z
    if size_sq < 0x100000:
        return 0
    short = 0x4000 - isqrt(size_sq)
    if short > 8 or short < -8:
        if short < -0x4000 or short > 0x2000:
            short = saturate(short, -0x4000, 0x2000)
        for axis in range(3):
            part = block[A_GRAVITY + axis]
            block[A_GRAVITY + axis] = part + ((part >> 8) * short >> 6)
    return 1


@hot
def angles(block: Ints) -> int:
    """Write roll and pitch of the gravity vector: up in the body is (-ca sb, sa, ca cb). Returns 0.

    Roll lies within +-90 deg, pitch within +-180 deg: a robot on its back reads as pitched over.
    """
    x = block[A_GRAVITY] >> 7
    y = block[A_GRAVITY + 1] >> 7
    z = block[A_GRAVITY + 2] >> 7
    block[A_PITCH] = atan2_brad(-x, z)
    block[A_ROLL] = atan2_brad(y, hypot(x, z))
    return 0
