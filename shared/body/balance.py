"""Keeps the body level: two PIDs in parallel, roll and pitch (paper A, section 2.5.2, figure 6).

Their outputs are body angles added to the commanded pose. The paper's limiter holds each
integral term and the sum of both outputs' sizes.
"""

from ..num.fixed import mul_q15, saturate
from ..num.pid import Pid, pid_reset, pid_step
from ..runtime import hot
from .axes import Pose, Tilt
from .params import Params


class Balance:
    """Both controllers of one robot, and the correction that they add to the commanded pose."""

    def __init__(self) -> None:
        self.roll = Pid()
        self.pitch = Pid()
        self.correction = Tilt()


@hot
def balance_setup(params: Params, balance: Balance) -> None:
    """Take the robot's gains and limits and clear the state."""
    setup_pid(params, balance.roll)
    setup_pid(params, balance.pitch)
    balance_reset(balance)


@hot
def setup_pid(params: Params, pid: Pid) -> None:
    """Take the robot's gains and limits for one controller."""
    gains = params.gains
    pid.kp_q12 = gains.kp_q12
    pid.ki_q16 = gains.ki_q16
    pid.kd_q10 = gains.kd_q10
    pid.integral_max = params.integral_max
    pid.output_max = params.balance_max


@hot
def balance_reset(balance: Balance) -> None:
    """Forget the state of both controllers and set the correction to 0."""
    pid_reset(balance.roll)
    pid_reset(balance.pitch)
    balance.correction.roll = 0
    balance.correction.pitch = 0


@hot
def balance_release(balance: Balance, step: int) -> None:
    """Fade the correction out by at most ``step`` brad (>= 0), and forget the controllers' state.

    For a tick without balance: an abrupt end of the correction would jerk the body.
    """
    correction = balance.correction
    pid_reset(balance.roll)
    pid_reset(balance.pitch)
    correction.roll -= saturate(correction.roll, -step, step)
    correction.pitch -= saturate(correction.pitch, -step, step)


@hot
def balance_step(balance: Balance, pose: Pose, roll_brad: int, pitch_brad: int) -> None:
    """Update the correction from the commanded ``pose`` and the measured angles.

    roll_brad, pitch_brad: within +-32768. The corrections' sizes add up to at most the limit: beyond it both shrink
    alike. Error at most 3 brad. Intermediates: 16383 * 32768 < 2^30.
    """
    roll = pid_step(balance.roll, pose.roll, roll_brad)
    pitch = pid_step(balance.pitch, pose.pitch, pitch_brad)
    size = roll
    if size < 0:
        size = -size
    if pitch < 0:
        size -= pitch
    else:
        size += pitch
    limit = balance.roll.output_max
    if size > limit:
        share_q15 = (limit << 15) // size
        roll = mul_q15(roll, share_q15)
        pitch = mul_q15(pitch, share_q15)
    balance.correction.roll = roll
    balance.correction.pitch = pitch
