"""Commissioning's fourth part: the rotor swings to and fro, and work and energy give inertia and friction.

From where the rotor reverses to the middle the current does the work J v^2 / 2 + F s, from the middle to where it
reverses again F s - J v^2 / 2. Their difference gives the inertia, their sum the friction. A torque that depends on the
angle alone (cogging) gives back the work that it takes. A load that pulls one way shows as the mean of the current. The
middle is a stretch, over which the work passes gradually from one sum to the other: the speed is a mean over it, so the
torques there must be too. First the current swings the rotor as in spinning.py, which gives the velocity loop a first
gain. Then that loop swings it, so gently that the gear's play costs nothing, at two speeds, to find the part of the
friction that grows with the speed.
"""

from ..num.fixed import isqrt, ratio, saturate
from ..runtime import const, hot
from .cascade import velocity_loop, write_current
from .commission_state import PHASE_SWING, Commission, begin_phase, fail
from .faults import FAULT_COMMISSION_FRICTION, FAULT_COMMISSION_INERTIA, FAULT_COMMISSION_LOAD
from .layout import CurrentLoop, JointSettings, JointState
from .outer import set_outer_gains
from .probe import probe_begin
from .spinning import swing, swing_current, swing_rate, turn_round

_LEVELS = const(4)  # by the current; by the velocity loop; again with a better gain; at half of that speed
_PERIODS = const(3)
_TICKS_MOST = const(8000)  # of a level: 8000 times ten currents of 12288 stay below 2^30
_WORK_MOST = const(0x3FFFFFF)
_MOVED_MOST = const(1023)
_MIDDLE = const(1024)  # rc to either side of the middle, 1/8 turn in all
_BRAKING = const(4000)  # rc: twice the way in which the velocity loop brings the rotor to rest
_SLOW_MOST = const(300)  # ticks to the speed limit with half of the current (chosen; the parallel robot's need 110)
_LEAST = const(512)  # slowest swing, rate: 2 rc a tick


@hot
def mechanics_begin(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> None:
    """Begin to swing, with current across the flux only."""
    loop.reference_d = 0
    commission.swing_level = 0
    commission.swing_rate = swing_rate(settings, commission)
    _begin_level(loop, commission)


@hot
def _begin_level(loop: CurrentLoop, commission: Commission) -> None:
    commission.half_swings = 0
    commission.periods = -1
    commission.period_ticks = 0
    commission.impulse = 0
    commission.work_in = 0
    commission.work_out = 0
    commission.way_in = 0
    commission.way = 0
    commission.square_middle = 0
    commission.way_middle = 0
    commission.square_way = 0
    probe_begin(loop, 1)
    begin_phase(commission, PHASE_SWING)


@hot
def mechanics_step(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Do one tick; return 1 when inertia and friction are found."""
    before = commission.swing_position
    current = loop.sum_current_q
    probe_begin(loop, 1)
    moved = saturate(swing(loop, state, commission), -_MOVED_MOST, _MOVED_MOST)
    turn_round(commission)
    if commission.swing_level == 0:
        loop.reference_q = swing_current(settings, state, commission, commission.swing_rate)
    else:
        follow_rate(loop, settings, state, commission)
    if commission.phase_ticks > _TICKS_MOST:
        fail(commission, FAULT_COMMISSION_FRICTION, commission.lag)
    if commission.reason:
        return 0
    _add(commission, before, moved, current)
    if commission.periods < _PERIODS:
        return 0
    return _end_level(loop, settings, state, commission)


@hot
def follow_rate(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> None:
    """Let the velocity loop follow a rate that goes to and fro with a constant acceleration."""
    ask_rate(settings, state, commission)
    write_current(loop, settings, state)


@hot
def ask_rate(settings: JointSettings, state: JointState, commission: Commission) -> None:
    """As follow_rate, but without handing the current to the current step."""
    wanted = commission.swing_rate * commission.sign
    most = commission.swing_acceleration
    reference = commission.swing_reference * commission.sign
    if reference > commission.swing_rate or reference < -commission.swing_rate:
        most = most << 2  # from the level before, at twice the speed
    commission.swing_reference += saturate(wanted - commission.swing_reference, -most, most)
    state.rate_reference = commission.swing_reference * commission.direction * settings.joint_sign
    velocity_loop(settings, state, 0)


@hot
def _add(commission: Commission, before: int, moved: int, current: int) -> None:
    """Add up the work of one tick; it passes from one sum to the other over the middle.

    A period begins and ends where the middle is passed upwards; sums begin at the first passage. Intermediates:
    2^16 * 2^11.
    """
    work = saturate(current * moved, -_WORK_MOST, _WORK_MOST) + 512 >> 10
    if commission.half_swings > 1 and moved > 0 and (before ^ commission.swing_position) < 0:
        commission.periods += 1
    if commission.periods < 0 or commission.periods == _PERIODS:
        return
    commission.period_ticks += 1
    commission.impulse += current
    commission.square_way += moved * moved >> 4
    ahead = saturate(commission.swing_position, -_MIDDLE, _MIDDLE)
    if moved < 0:
        ahead = -ahead
    towards = work * (_MIDDLE - ahead) + 1024 >> 11
    commission.work_in += towards
    commission.work_out += work - towards
    commission.way_in += moved * (_MIDDLE - ahead) + 1024 >> 11
    way = moved
    if moved < 0:
        way = -moved
    commission.way += way
    if commission.swing_position > -_MIDDLE and commission.swing_position < _MIDDLE:
        commission.square_middle += (moved * moved >> 4) * way >> 8
        commission.way_middle += way


@hot
def _end_level(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Find inertia and friction from the sums of a level; begin the next one and return 0, or 1 after the last."""
    level = commission.swing_level
    commission.friction_q4[level] = ratio(commission.work_in + commission.work_out, commission.way, 14) // 10
    commission.speed_q4[level] = ratio(commission.square_way, commission.way, 8)
    if level < _LEVELS - 1:
        _find_inertia(settings, commission)
    if commission.reason:
        return 0
    commission.swing_level = level + 1
    if level == 0:
        state.velocity_integral = 0
        commission.swing_reference = state.rate * commission.direction
    elif level == 2:
        commission.swing_rate = commission.swing_rate >> 1
    elif level > 2:
        loop.probing = 0
        _find_friction(commission)
        set_outer_gains(settings, commission.inertia, settings.velocity_w)
        return _check_load(settings, commission)
    _choose_acceleration(settings, commission)
    _begin_level(loop, commission)
    return 0


@hot
def _check_load(settings: JointSettings, commission: Commission) -> int:
    """Return 1 if half of the current limit brings the rotor to the speed limit soon enough, else 0."""
    acceleration = (settings.commission_current << 12) // saturate(commission.inertia, 1, 0x3FFFF)
    ticks = settings.rate_max // saturate(acceleration, 1, 0x3FFFFFF)
    if ticks > _SLOW_MOST:
        fail(commission, FAULT_COMMISSION_LOAD, ticks)
        return 0
    return 1


@hot
def _choose_acceleration(settings: JointSettings, commission: Commission) -> None:
    """Choose acceleration and speed: braking takes _BRAKING / 2, and at most a quarter of the current limit."""
    rate = saturate(commission.swing_rate, _LEAST, 0x3FFFF) >> 4
    most = (settings.commission_current << 11) // saturate(commission.inertia, 1, 0x3FFFF)
    acceleration = rate * rate // _BRAKING + 1
    if acceleration > most:
        acceleration = saturate(most, 1, 0xFFFF)
        commission.swing_rate = isqrt(acceleration * _BRAKING) << 4
    commission.swing_acceleration = acceleration


@hot
def _find_inertia(settings: JointSettings, commission: Commission) -> None:
    """Find the inertia in cu / (rate / tick), Q12, and the gains of the velocity loop, or refuse them."""
    mean = commission.impulse // saturate(commission.period_ticks, 1, _TICKS_MOST)
    pulled = (mean >> 3) * saturate(commission.way_in, -0x3FFF, 0x3FFF) >> 6
    work = commission.work_in - commission.work_out - pulled
    square = (commission.square_middle << 8) // saturate(commission.way_middle, 1, _WORK_MOST)
    commission.inertia = ratio(work >> 1, (square << 4) * _PERIODS, 14) // 10
    w = settings.velocity_w
    fits = set_outer_gains(settings, commission.inertia, w)
    if fits == 0 or set_outer_gains(settings, commission.inertia, w >> 1) == 0:
        fail(commission, FAULT_COMMISSION_INERTIA, commission.inertia)


@hot
def _find_friction(commission: Commission) -> None:
    """Find the friction at rest and its growth with the speed; neither is below 0."""
    slower = commission.speed_q4[2] - commission.speed_q4[3]
    more = commission.friction_q4[2] - commission.friction_q4[3]
    commission.viscous = ratio(more, slower, 8)
    rest = commission.friction_q4[2] - (commission.viscous * commission.speed_q4[2] >> 8)
    if rest < 0:
        rest = 0
    commission.coulomb = rest
