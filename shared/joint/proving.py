"""Commissioning's proofs: does each loop have the bandwidth that it was given?

Current: a small sine at the wanted bandwidth, added up in the interrupt. At its bandwidth a loop's response is as large
as its error, whatever the delays: |L| = 1. The mean of d and q is taken, because both have the gain for the mean
inductance. Velocity: the rotor runs, and steps of its speed up and down again take the momentum of the inertia that
turns: the bandwidth is kp / J. Friction and a load that pulls cancel. Position: steps ahead and back during the run; p
times the area of the error in three time constants is 0.87 of the step, by a model of the nested loops.
"""

from ..num.fixed import hypot, ratio, saturate
from ..runtime import const, hot
from .cascade import velocity_loop, write_current
from .commission_state import PHASE_PROVE_POSITION, PHASE_PROVE_VELOCITY, STEPS, Commission, begin_phase, fail
from .faults import FAULT_COMMISSION_CURRENT_LOOP, FAULT_COMMISSION_POSITION_LOOP, FAULT_COMMISSION_VELOCITY_LOOP
from .layout import CurrentLoop, JointSettings, JointState
from .outer import set_outer_gains
from .probe import SINE_ON_D, SINE_ON_Q, probe_begin, sine_begin
from .spinning import swing, swing_rate, turn_round
from .swinging import follow_rate

_SINE_TICKS = const(256)
_LEAST = const(85)  # per cent of the wanted bandwidth
_MOST = const(115)
_LEAST_OUTER = const(67)  # of velocity and position; 78 motors with their cogging compensated had 82 .. 132
_MOST_OUTER = const(150)
_LOWER_VELOCITY = const(75)  # below this, a quarter less bandwidth is tried
_SHARE_MOST = const(999)  # per cent
_WINDOW = const(786432)  # of a velocity step: 12 / w, for w in rad / tick, Q16
_WINDOW_MOST = const(500)  # ticks
_RUN = const(224694)  # rc/256: a run's slower speed times a window, so that seven windows are 3/8 turn
_RUNS = const(4)  # of the velocity loop, to and fro
_RUNS_POSITION = const(2)
_REPEATS_POSITION = const(2)  # of a measurement that fails, twice as fast
_TICKS_MOST = const(16000)  # of the runs with one bandwidth
_CONSTANTS = const(49152)  # ticks times position_p: three time constants of the position loop
_AREA = const(87)  # per cent of a step over p, if the inner loop has 3.75 times the bandwidth; 85 with 2.5, 90 with 6
_ERROR_MOST = const(8191)  # rc
_IMPULSE_MOST = const(0x1FFFFFFF)


@hot
def prove_current(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Do one tick; return 1 when both axes of the current loop are measured and have their bandwidth."""
    if loop.probing < SINE_ON_D:
        loop.level_current = settings.commission_current
        commission.proved = 0
        sine_begin(loop, settings, SINE_ON_D)
    if commission.phase_ticks < _SINE_TICKS:
        return 0
    commission.phase_ticks = 0
    probing = loop.probing
    loop.probing = 0
    loop.reference_d = settings.commission_current
    loop.reference_q = 0
    missed = hypot(loop.sum_voltage_d, loop.sum_voltage_q)
    commission.proved += saturate(ratio(missed, hypot(loop.sum_current_d, loop.sum_current_q), 12), 1, 0xFFFF)
    if probing == SINE_ON_D:
        sine_begin(loop, settings, SINE_ON_Q)
        return 0
    share = saturate(819200 // commission.proved, 0, _SHARE_MOST)
    if share < _LEAST or share > _MOST:
        fail(commission, FAULT_COMMISSION_CURRENT_LOOP, share)
        return 0
    return 1


@hot
def prove_begin(settings: JointSettings, commission: Commission) -> None:
    """Begin to run to and fro with steps of the speed."""
    commission.velocity_w = settings.velocity_w
    commission.repeated = 0
    _begin_velocity(settings, commission)


@hot
def _begin_velocity(settings: JointSettings, commission: Commission) -> None:
    """Run with the gains of commission.velocity_w; the second time twice as fast, to get over strong cogging."""
    set_outer_gains(settings, commission.inertia, commission.velocity_w)
    window = saturate(_WINDOW // saturate(commission.velocity_w, 1, 20588), 8, _WINDOW_MOST) >> commission.repeated
    commission.window = window
    commission.swing_rate = saturate(_RUN // window, 1, swing_rate(settings, commission) >> 1)
    _begin_runs(commission, PHASE_PROVE_VELOCITY)


@hot
def _begin_runs(commission: Commission, phase: int) -> None:
    commission.swing_acceleration = (commission.swing_rate >> 5) + 1
    commission.half_swings = 0
    commission.run_ticks = -1
    commission.impulse = 0
    commission.way = 0
    begin_phase(commission, phase)


@hot
def prove_step(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Do one tick; return 1 when velocity and position loop have their bandwidths."""
    current = loop.sum_current_q // STEPS - loop.cogging_q
    probe_begin(loop, 1)
    moved = swing(loop, state, commission)
    sign = commission.sign
    if turn_round(commission) != sign:
        commission.run_ticks = -1
    if commission.phase_ticks > _TICKS_MOST:
        fail(commission, FAULT_COMMISSION_VELOCITY_LOOP, 0)
    if commission.reason:
        return 0
    if commission.phase == PHASE_PROVE_VELOCITY:
        _run_velocity(loop, settings, state, commission, current * commission.sign, moved * commission.sign)
        return 0
    return _run_position(loop, settings, state, commission)


@hot
def _run_velocity(
    loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission, current: int, moved: int
) -> None:
    """Do one tick of a run, of five windows: slow, fast, fast, slow, slow."""
    slow = commission.swing_rate
    ticks = commission.run_ticks
    window = commission.window
    most = commission.swing_acceleration
    ahead = commission.swing_position * commission.sign
    if ticks >= 0 or (ahead + (slow * window * 7 >> 9) > 0 and commission.half_swings > 0):
        commission.run_ticks = ticks + 1
        _add_weighted(commission, ticks + 1, current, moved)
        if ticks >= window and ticks < 3 * window:
            commission.swing_rate = slow << 1
        if ticks >= window:
            commission.swing_acceleration = 0x3FFFF
    follow_rate(loop, settings, state, commission)
    commission.swing_rate = slow
    commission.swing_acceleration = most
    if commission.half_swings > _RUNS:
        _end_velocity(settings, commission)


@hot
def _add_weighted(commission: Commission, ticks: int, current: int, moved: int) -> None:
    """Add up a tick with its weight.

    The mean speed changes from window 0 to 2 by the current, weighted from 0 up to 1 in window 0, and down to 0 again
    in window 2. From 2 to 4 it is the same with the other sign: what acts alike both ways (friction, a load), or grows
    with the speed, cancels.
    """
    window = saturate(commission.window, 1, _WINDOW_MOST)
    part = ticks // window
    weight = (ticks - part * window << 5) // window
    if part == 0:
        commission.way -= moved
    elif part == 1:
        weight = 32
    elif part == 2:
        commission.way += moved + moved
        weight = 32 - weight - weight
    elif part == 3:
        weight = -32
    elif part == 4:
        commission.way -= moved
        weight -= 32
    else:
        weight = 0
    commission.impulse = saturate(commission.impulse + current * weight, -_IMPULSE_MOST, _IMPULSE_MOST)


@hot
def _end_velocity(settings: JointSettings, commission: Commission) -> None:
    """Find the bandwidth in per cent of the wanted one; go on with the position loop.

    A poor result is measured once more. A load that rattles in the gear's play swallows momentum: then a quarter less
    bandwidth is tried, twice.
    """
    inertia = ratio(commission.impulse, saturate(commission.way, 1, 0x3FFFFFF), 4)
    inertia = inertia * commission.window >> 5  # Q12: 4096 / (32 256), of it 16
    share = saturate(commission.inertia * 100 // saturate(inertia, 1, 0x3FFFF), 0, _SHARE_MOST)
    commission.proved = share
    if _try_again(settings, commission, share):
        _begin_velocity(settings, commission)
    elif share < _LEAST_OUTER or share > _MOST_OUTER:
        fail(commission, FAULT_COMMISSION_VELOCITY_LOOP, share)
    else:
        commission.repeated = 0
        _begin_position(settings, commission)


@hot
def _try_again(settings: JointSettings, commission: Commission, share: int) -> int:
    """Return 1 if a share is poor and to be measured again: faster, then with a quarter less bandwidth, twice."""
    if share >= _LOWER_VELOCITY and share <= _MOST_OUTER:
        return 0
    if commission.repeated == 0:
        commission.repeated = 1
        return 1
    if share > _MOST_OUTER or commission.velocity_w <= settings.velocity_w * 5 >> 3:
        return 0
    commission.velocity_w -= settings.velocity_w >> 2
    return 1


@hot
def _begin_position(settings: JointSettings, commission: Commission) -> None:
    commission.window = saturate(_CONSTANTS // saturate(settings.position_p, 1, 4095), 8, _WINDOW_MOST)
    _begin_runs(commission, PHASE_PROVE_POSITION)


@hot
def _run_position(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Do one tick of a run: the position loop takes over, after a window its goal jumps. Return 1 after the last."""
    slow = commission.swing_rate
    window = commission.window
    ticks = commission.run_ticks
    ahead = commission.swing_position * commission.sign
    if ticks < 0 and (commission.half_swings < 1 or ahead + (slow * window >> 8) < 0):
        commission.goal = commission.swing_position << 8
        follow_rate(loop, settings, state, commission)
        return 0
    commission.run_ticks = ticks + 1
    commission.goal += slow * commission.sign
    jump = (slow >> 1) * 64 // saturate(settings.position_p, 1, 4095)
    if commission.half_swings & 2:
        jump = -jump
    if ticks == window:
        commission.goal += (jump * commission.sign) << 8
        commission.way += saturate(jump, 0, _ERROR_MOST) + saturate(-jump, 0, _ERROR_MOST)
    return _hold_position(loop, settings, state, commission, jump)


@hot
def _hold_position(
    loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission, jump: int
) -> int:
    """Run the position loop and add up its error after the jump; return 1 after the last run."""
    error = saturate((commission.goal >> 8) - commission.swing_position, -_ERROR_MOST, _ERROR_MOST)
    ticks = commission.run_ticks
    window = commission.window
    along = error * commission.sign
    if jump < 0:
        along = -along
    if ticks <= window and ticks > window >> 1:
        commission.impulse -= along + along
    elif ticks > window + 1 and ticks <= window + window + 1:
        commission.impulse += along
    rate = commission.swing_rate * commission.sign + (error * settings.position_p >> 6)
    state.rate_reference = rate * commission.direction * settings.joint_sign
    commission.swing_reference = rate
    velocity_loop(settings, state, 0)
    write_current(loop, settings, state)
    if commission.half_swings > _RUNS_POSITION:
        return _end_position(settings, commission)
    return 0


@hot
def _end_position(settings: JointSettings, commission: Commission) -> int:
    """Find the bandwidth in per cent of the wanted one; return 1, or 0 if it is not reached."""
    area = saturate(commission.impulse, 1, 0x3FFFFF) * (settings.position_p >> 3) >> 11
    share = saturate(commission.way * _AREA // saturate(area, 1, 0x3FFFFF), 0, _SHARE_MOST)
    commission.proved = share
    if share >= _LEAST_OUTER and share <= _MOST_OUTER:
        return 1
    if commission.repeated == _REPEATS_POSITION:
        fail(commission, FAULT_COMMISSION_POSITION_LOOP, share)
        return 0
    if commission.repeated == 0:
        commission.swing_rate = saturate(commission.swing_rate << 1, 1, swing_rate(settings, commission) >> 1)
    commission.repeated += 1
    _begin_position(settings, commission)
    return 0
