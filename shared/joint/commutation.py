"""Commutation: the electrical angle that the current step uses, and its sine table.

The angle is electrical_gain times the rotor's count plus electrical_offset. A joint in use follows its rotor as stored;
commissioning makes a field point anywhere, whatever the encoder reads, or follows the rotor as found so far.
"""

from ..num.fixed import saturate, sin_q15
from ..runtime import const, hot
from .commission_state import Commission
from .layout import SINE_SIZE, CurrentLoop, JointSettings, JointState

TABLE_HALF_STEP = const(32)  # brad, added to an angle so that the nearest entry of the table is taken
_STEP_SHIFT = const(6)  # brad between entries: 64
_RATE_MOST = const(0x7FFFF)
_LEAD_SHIFT = const(8)  # 4 brad a rate unit in 2560 steps, for the 2.5 steps from a reading until its voltage acts


@hot
def fill_sine(loop: CurrentLoop) -> None:
    """Write the sine table, in Q15, to ``loop`` when a joint starts. Error 1 of Q15, from sin_q15.

    1024 entries a turn and one quarter more, for the cosine. The step rotates an entry (s, c) by the rest r of the
    angle, at most 32 brad, with s + c r and c - s r: error r^2 / 2 < 5e-6. The table is a part of ``loop``, because
    each further array passed to a viper function costs some 110 instructions a call.
    """
    for at in range(SINE_SIZE):
        loop.sine[at] = sin_q15(at << _STEP_SHIFT)


@hot
def commutate(loop: CurrentLoop, pole_pairs: int, direction: int, offset_brad: int) -> None:
    """Let the angle follow the rotor, from ``offset_brad`` at its count 0."""
    loop.electrical_offset = offset_brad + TABLE_HALF_STEP
    loop.electrical_gain = 4 * pole_pairs * direction


@hot
def set_commutation(loop: CurrentLoop, settings: JointSettings) -> None:
    """Follow the rotor with the stored direction, pole pairs and offset."""
    commutate(loop, settings.pole_pairs, settings.direction, settings.elec_offset)


@hot
def lead_angle(loop: CurrentLoop, settings: JointSettings, state: JointState) -> int:
    """Set electrical_offset so that the last reading of the rotor gives the angle at the samples; return it in brad.

    An answer of the encoder is one step old (``age`` 0 .. 2047, rate within +-(2^19 - 1)). Error at most 1 brad plus
    the rate's error. Intermediates: 2^19 * 2047 is below 2^30.
    """
    lead = saturate(state.rate, -_RATE_MOST, _RATE_MOST) * settings.age >> 16
    if loop.electrical_gain < 0:
        lead = 0 - lead
    loop.electrical_offset = settings.elec_offset + TABLE_HALF_STEP + lead
    return loop.electrical_offset


@hot
def follow_rotor(loop: CurrentLoop, state: JointState, commission: Commission) -> None:
    """Follow the rotor by what commissioning found, ahead by the angle that it goes until a voltage acts."""
    lead = state.rate * commission.direction * commission.pole_pairs >> _LEAD_SHIFT
    commutate(loop, commission.pole_pairs, commission.direction, commission.offset_found + lead)


@hot
def point(loop: CurrentLoop, commission: Commission) -> None:
    """Point the field at commission.angle, whatever the encoder says."""
    loop.electrical_gain = 0
    loop.electrical_offset = (commission.angle & 0xFFFF) + TABLE_HALF_STEP
