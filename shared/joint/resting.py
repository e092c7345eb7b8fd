"""Commissioning before any current flows: with the bridge off, the sensors' readings, the supply, a rotor at rest."""

from ..runtime import const, hot
from .bend import fill_bend
from .cogging import switch_waves
from .commission_state import COMMISSION_FULL, PHASE_RAMP, Commission, begin_phase, fail
from .current import current_reset, set_offsets
from .encoder import wrap_count
from .faults import (
    FAULT_COMMISSION_BUS,
    FAULT_COMMISSION_ENCODER,
    FAULT_COMMISSION_MOVING,
    FAULT_COMMISSION_NOISE,
    FAULT_COMMISSION_OFFSET,
    FAULT_NONE,
)
from .layout import CurrentLoop, JointIo, JointSettings, JointState
from .outer import keep_outer

_ROTOR = const(3)  # its place in lowest and highest, behind the phases
_FRESH_TICKS = const(4)  # until the rotor's readings are without the old table
_REST_TICKS = const(256)
_REST_SHIFT = const(8)  # of these
_NOISE_MOST = const(24)  # counts peak to peak: 0.1 A
_ENCODER_NOISE_MOST = const(8)  # rc peak to peak
_MOVED_MOST = const(64)  # rc that noise alone may seem to move


@hot
def rest_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> None:
    """Do one tick: collect 256 readings, then check them and set the current offsets."""
    if commission.phase_ticks == 1:
        commission.final_kp = loop.kp
        commission.final_ki = loop.ki
        keep_outer(settings, commission)
        switch_waves(loop, 0)
        if commission.kind == COMMISSION_FULL:
            state.homed = 0
            fill_bend(loop, 0, 0, 0, 0)
    if commission.phase_ticks < _FRESH_TICKS:
        commission.rest_rotor = loop.rotor
        commission.rest_joint = io.joint_raw
        return
    for phase in range(3):
        raw = loop.raw[phase]
        commission.raw_sum[phase] = commission.raw_sum[phase] + raw
        _extremes(commission, phase, raw)
    _extremes(commission, _ROTOR, wrap_count(loop.rotor - commission.rest_rotor))
    if commission.phase_ticks < _FRESH_TICKS + _REST_TICKS - 1:
        return
    if _check_rest(loop, settings, state, commission):
        return
    shift = _REST_SHIFT - 4
    set_offsets(loop, commission.raw_sum[0] >> shift, commission.raw_sum[1] >> shift, commission.raw_sum[2] >> shift)
    loop.kp = 0  # these may be another motor's
    loop.ki = 0
    current_reset(loop, loop.rotor)
    begin_phase(commission, PHASE_RAMP)


@hot
def _check_rest(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Return FAULT_NONE if the currents, the supply and the rotor at rest are fit, else the first fault."""
    for phase in range(3):
        offset = commission.raw_sum[phase] >> _REST_SHIFT
        if offset > 2048 + settings.offset_spread or offset < 2048 - settings.offset_spread:
            return fail(commission, FAULT_COMMISSION_OFFSET, offset)
        noise = commission.highest[phase] - commission.lowest[phase]
        if noise > _NOISE_MOST:
            return fail(commission, FAULT_COMMISSION_NOISE, noise)
    if state.bus < settings.commission_bus_least or state.bus > settings.commission_bus_most:
        return fail(commission, FAULT_COMMISSION_BUS, state.bus)
    noise = commission.highest[_ROTOR] - commission.lowest[_ROTOR]
    moved = wrap_count(loop.rotor - commission.rest_rotor)
    if noise > _ENCODER_NOISE_MOST and moved <= _MOVED_MOST and moved >= -_MOVED_MOST:
        return fail(commission, FAULT_COMMISSION_ENCODER, noise)
    if noise > _ENCODER_NOISE_MOST or state.rate > settings.stall_rate or state.rate < -settings.stall_rate:
        return fail(commission, FAULT_COMMISSION_MOVING, state.rate)
    return FAULT_NONE


@hot
def _extremes(commission: Commission, place: int, value: int) -> None:
    """Update the lowest and highest at ``place`` with a value."""
    if value < commission.lowest[place]:
        commission.lowest[place] = value
    if value > commission.highest[place]:
        commission.highest[place] = value
