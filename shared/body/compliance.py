"""How far the joints sag under a foot's load, fed forward: dq = J^T F / K (paper A's legs, eqs 1-6).

Servos without integral gain, like brushless joints with soft position loops, sag in proportion to torque. Raising the
goals by the expected sag puts the foot where it was meant to be, without a loop and so without a delay. With a calf
motor on the body (paper B) the thigh's motor only carries what acts at the knee, because the calf's angle to the body
is set by the other motor.
"""

from ..num.fixed import cos_q15, mul_q15, saturate, sin_q15
from ..runtime import Ints, const, hot
from .feet import Feet
from .params import CALF, THIGH, Params

_FORCE_MAX_Q12 = const(16383)  # four times the own weight
_SAG_MAX_BRAD = const(2730)  # 15 deg: beyond it a servo gives its full torque anyway


@hot
def torque(lever_lu: int, force_q12: int) -> int:
    """Return lever * force in own weight times lu, limited to +-32767.

    Range: lever within +-32767 lu, force within +-16383 (Q12 of the own weight). Error at most 1/2.
    Intermediates: 32767 * 16383 + 2^11 < 2^30.
    """
    return saturate(lever_lu * force_q12 + 2048 >> 12, -32767, 32767)


@hot
def sag(torque_lu: int, give_q16: int) -> int:
    """Return the sag in brad of a joint under a torque (own weight times lu), limited to +-15 deg.

    The torque is limited to +-32767. Range: give 0 .. 32767 brad per lu in Q16. Error at most 1/2 brad.
    """
    if torque_lu > 32767:
        torque_lu = 32767
    elif torque_lu < -32767:
        torque_lu = -32767
    given = torque_lu * give_q16 + 0x8000 >> 16
    if given > _SAG_MAX_BRAD:
        return _SAG_MAX_BRAD
    if given < -_SAG_MAX_BRAD:
        return -_SAG_MAX_BRAD
    return given


@hot
def sag_leg(params: Params, leg: int, hip_feet: Feet, fx_q12: int, fy_q12: int, fz_q12: int, joints: Ints) -> None:
    """Add to the three angles of ``leg`` in ``joints`` how far they will sag under a force on its foot.

    hip_feet: lu, each from its hip in body axes, within +-32767; joints: 12 brad, the angles that reach it. fx, fy, fz:
    the ground's push on the foot in body axes, Q12 of the robot's own weight, each limited to +-16383. Error at most
    1.5 brad + 1e-4 of the sag. Intermediates as in torque and sag.
    """
    foot = hip_feet.legs[leg]
    at = leg * 3
    fz = saturate(fz_q12, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)
    x = foot.x
    thigh = joints[at + THIGH]
    length = params.legs[leg].thigh_length
    knee_x = -(length * sin_q15(thigh) + 0x4000 >> 15)  # mul_q15 without its call
    above = knee_x * fz + 2048 >> 12
    below = (x - knee_x) * fz + 2048 >> 12
    around = foot.y * fz + 2048 >> 12
    if fx_q12 or fy_q12:
        fx = saturate(fx_q12, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)
        fy = saturate(fy_q12, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)
        sine = sin_q15(joints[at])
        cosine = cos_q15(joints[at])
        around -= torque(foot.z, fy)
        knee_drop = mul_q15(length, cos_q15(thigh))
        drop = mul_q15(foot.y, sine) - mul_q15(foot.z, cosine)
        along = saturate(mul_q15(fz, cosine) - mul_q15(fy, sine), -_FORCE_MAX_Q12, _FORCE_MAX_Q12)
        above = torque(knee_x, along) + torque(knee_drop, fx)
        below = torque(x - knee_x, along) + torque(drop - knee_drop, fx)
    joints[at] -= sag(around, params.sag_q16.hip)
    if params.coupled:
        give = sag(above, params.sag_q16.thigh)
        joints[at + THIGH] += give
        joints[at + CALF] += sag(below, params.sag_q16.calf) - give
    else:
        joints[at + THIGH] += sag(above + below, params.sag_q16.thigh)
        joints[at + CALF] += sag(below, params.sag_q16.calf)
