"""Writes what commissioning found to the joint's settings, all at once and only when everything is found."""

from ..num.fixed import ratio, saturate
from ..runtime import const, hot
from .bend import corrected_rotor
from .commission_state import PHASE_IDLE, Commission, begin_phase
from .layout import CurrentLoop, JointSettings, JointState

_OMEGA_L = const(322)  # 8 rate in electrical 2^-28 rad a step and pole pair: 4 / 320 brad
_DEAD_MOST = const(3276)  # of the parameter


@hot
def write_findings(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> None:
    """Write everything found and end commissioning."""
    before = settings.pole_pairs
    pairs = commission.pole_pairs
    settings.bemf = commission.flux
    settings.omega_l = ((commission.inductance_q >> 2) * pairs >> 4) * _OMEGA_L >> 10
    settings.dead = saturate(ratio(commission.dead_q4, saturate(state.bus, 1, 0x7FFF), 11), 0, _DEAD_MOST)
    if before > 0:
        settings.advance = settings.advance * pairs // before
        settings.age = settings.age * pairs // before
    commission.final_kp = loop.kp
    commission.final_ki = loop.ki
    commission.outer_before[0] = 0
    settings.elec_offset = commission.offset_found
    settings.direction = commission.direction
    settings.pole_pairs = pairs
    settings.bend_cos1 = commission.bend[0]
    settings.bend_sin1 = commission.bend[1]
    settings.bend_cos2 = commission.bend[2]
    settings.bend_sin2 = commission.bend[3]
    _write_waves(settings, commission)
    settings.commissioned = 1
    if settings.has_joint_encoder:
        same = commission.moved_forward ^ commission.joint_moved_forward
        settings.joint_encoder_sign = settings.joint_sign
        if same < 0:
            settings.joint_encoder_sign = -settings.joint_sign
    commission.rest_rotor = corrected_rotor(loop, commission.rest_rotor)
    if commission.pose_given:
        set_zeros(settings, commission)
    begin_phase(commission, PHASE_IDLE)


@hot
def _write_waves(settings: JointSettings, commission: Commission) -> None:
    """Write the cogging's waves."""
    settings.cogging_order_0 = commission.wave_order[0]
    settings.cogging_current_0 = saturate(commission.wave_current[0], 0, 0x7FFF)
    settings.cogging_phase_0 = commission.wave_phase[0]
    settings.cogging_order_1 = commission.wave_order[1]
    settings.cogging_current_1 = saturate(commission.wave_current[1], 0, 0x7FFF)
    settings.cogging_phase_1 = commission.wave_phase[1]
    settings.cogging_order_2 = commission.wave_order[2]
    settings.cogging_current_2 = saturate(commission.wave_current[2], 0, 0x7FFF)
    settings.cogging_phase_2 = commission.wave_phase[2]


@hot
def set_zeros(settings: JointSettings, commission: Commission) -> None:
    """Set both encoders' zeros from the pose at which they read rest_rotor and rest_joint.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    settings.zero = (commission.rest_rotor - commission.pose * settings.joint_sign) & 16383
    if settings.has_joint_encoder and settings.gear_q8 > 0:
        half = settings.gear_q8 >> 1
        angle = ((commission.pose << 8) + half) // settings.gear_q8
        settings.joint_encoder_zero = (commission.rest_joint - angle * settings.joint_encoder_sign) & 16383
