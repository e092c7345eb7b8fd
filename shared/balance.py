"""Keeps the body level: two PIDs in parallel, roll and pitch (paper A, section 2.5.2, figure 6).

Their outputs are body angles added to the commanded pose. The paper's limiter holds each
integral term and the sum of both outputs' sizes.
"""

from .body import POSE_PITCH, POSE_ROLL
from .fixed import mul_q15, saturate
from .params import P_BALANCE_MAX, P_INTEGRAL_MAX, P_KP_Q12
from .pid import (
    PID_INTEGRAL_MAX,
    PID_KD_Q10,
    PID_KI_Q16,
    PID_KP_Q12,
    PID_OUTPUT_MAX,
    PID_SIZE,
    pid_reset,
    pid_step,
)
from .runtime import const, hot, ptr32

BALANCE_ROLL = const(16)  # 2 * PID_SIZE: the correction, brad
BALANCE_PITCH = const(17)
BALANCE_SIZE = const(18)


@hot
def balance_setup(params, block) -> int:
    """Fill a BALANCE_SIZE block from the robot's gains and clear its state; return 0."""
    p = ptr32(params)
    b = ptr32(block)
    balance_gains(params, P_KP_Q12, block)
    for base in range(0, BALANCE_ROLL, PID_SIZE):
        b[base + PID_INTEGRAL_MAX] = p[P_INTEGRAL_MAX]
        b[base + PID_OUTPUT_MAX] = p[P_BALANCE_MAX]
    balance_reset(block)
    return 0


@hot
def balance_gains(params, first: int, block) -> int:
    """Take the three gains from ``params[first]`` on for both controllers, keeping their state; return 0."""
    p = ptr32(params)
    b = ptr32(block)
    for base in range(0, BALANCE_ROLL, PID_SIZE):
        b[base + PID_KP_Q12] = p[first]
        b[base + PID_KI_Q16] = p[first + 1]
        b[base + PID_KD_Q10] = p[first + 2]
    return 0


@hot
def balance_reset(block) -> int:
    """Forget what both controllers have learnt and correct by nothing; return 0."""
    b = ptr32(block)
    pid_reset(block, 0)
    pid_reset(block, PID_SIZE)
    b[BALANCE_ROLL] = 0
    b[BALANCE_PITCH] = 0
    return 0


@hot
def balance_release(block, step: int) -> int:
    """Let the correction fade by at most ``step`` brad (>= 0) and forget the rest; return 0.

    For a tick without balance: an abrupt end of the correction would jerk the body.
    """
    b = ptr32(block)
    pid_reset(block, 0)
    pid_reset(block, PID_SIZE)
    for axis in range(2):
        b[BALANCE_ROLL + axis] -= saturate(b[BALANCE_ROLL + axis], -step, step)
    return 0


@hot
def balance_step(block, pose, roll_brad: int, pitch_brad: int) -> int:
    """Update the correction in ``block`` from the commanded ``pose`` and the measured angles; return 0.

    pose: POSE_SIZE values, brad angles; roll_brad, pitch_brad: within +-32768. The corrections'
    sizes add up to at most the limit: beyond it both shrink alike. Error at most 3 brad.
    Intermediates: 16383 * 32768 < 2^30.
    """
    b = ptr32(block)
    w = ptr32(pose)
    roll = pid_step(block, 0, w[POSE_ROLL], roll_brad)
    pitch = pid_step(block, PID_SIZE, w[POSE_PITCH], pitch_brad)
    size = roll
    if size < 0:
        size = -size
    if pitch < 0:
        size -= pitch
    else:
        size += pitch
    limit = b[PID_OUTPUT_MAX]
    if size > limit:
        share_q15 = (limit << 15) // size
        roll = mul_q15(roll, share_q15)
        pitch = mul_q15(pitch, share_q15)
    b[BALANCE_ROLL] = roll
    b[BALANCE_PITCH] = pitch
    return 0
