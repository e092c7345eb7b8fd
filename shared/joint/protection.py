"""What ends the torque: supply, current, speed, position, stall, encoders, temperatures. First found is S_CAUSE.

Each check runs in every state, so that a cause that is still there also refuses clearing and arming.
Limits that only act (derating) set LIMIT_* bits; what is found here is a fault.
"""

from ..fixed import isqrt
from ..runtime import Ints, const, hot
from ..wire.names import (
    LIMIT_I2T,
    LIMIT_MCU_TEMPERATURE,
    LIMIT_STALL,
    LIMIT_VOLTAGE,
    LIMIT_WINDING_TEMPERATURE,
    MODE_CALIBRATING,
    MODE_POSITION,
    MODE_VELOCITY,
)
from .cascade import fall_q15
from .current import current_sum
from .encoder import encoder_resync
from .faults import (
    FAULT_CURRENT_SENSE,
    FAULT_EMERGENCY_STOP,
    FAULT_ENCODER_DISAGREE,
    FAULT_ENCODER_LOST,
    FAULT_MCU_HOT,
    FAULT_MCU_SENSOR,
    FAULT_NONE,
    FAULT_OVER_CURRENT,
    FAULT_OVER_SPEED,
    FAULT_OVER_VOLTAGE,
    FAULT_POSITION_LIMIT,
    FAULT_POSITION_RANGE,
    FAULT_STALL,
    FAULT_THERMISTOR_OPEN,
    FAULT_THERMISTOR_SHORT,
    FAULT_UNDER_VOLTAGE,
    FAULT_WINDING_HOT,
    damps_first,
)
from .layout import (
    F_GLITCHES,
    F_I_D,
    F_I_Q,
    F_LIMITED,
    F_MASKED,
    F_TRIPPED,
    IO_E_STOP,
    IO_HARDWARE_FAULT,
    IO_HARDWARE_VALUE,
    IO_MCU_RAW,
    IO_THERMISTOR_RAW,
    K_BAD_TICKS,
    K_BUS_TICKS,
    K_CURRENT_MAX,
    K_DISAGREE_TICKS,
    K_GLITCH_STEPS,
    K_I2T_CURRENT,
    K_MCU_CAL1,
    K_MCU_CAL2,
    K_MCU_CUT,
    K_MCU_DERATE,
    K_OPEN_RAW,
    K_OVER,
    K_POSITION_MARGIN,
    K_POSITION_MAX,
    K_POSITION_MIN,
    K_RATE_TRIP,
    K_SHORT_RAW,
    K_STALL_RATE,
    K_STALL_TICKS,
    K_SUM_LIMIT,
    K_SUM_TICKS,
    K_UNDER,
    K_WINDING_CUT,
    K_WINDING_DERATE,
    S_BAD_TICKS,
    S_BUS,
    S_CAUSE,
    S_CAUSE_VALUE,
    S_CURRENT_LIMIT,
    S_CURRENT_REF,
    S_DERATE,
    S_DISAGREE_TICKS,
    S_HEAT_SUM,
    S_HEAT_TICKS,
    S_HOMED,
    S_JOINT_ERROR,
    S_LIMITS,
    S_MCU,
    S_MODE,
    S_OVER_TICKS,
    S_POSITION,
    S_RAISED,
    S_RAISED_VALUE,
    S_RATE_REF,
    S_SHIFTED,
    S_SLOW_CAUSE,
    S_SLOW_LIMITS,
    S_SLOW_VALUE,
    S_STALL_TICKS,
    S_SUM_TICKS,
    S_THERMAL_STARTED,
    S_TORQUE,
    S_TURNS,
    S_UNDER_TICKS,
    S_VELOCITY,
    S_WINDING,
    TORQUE_DRIVE,
    TORQUE_OFF,
)
from .thermal import i2t_step, mcu_t16, model_reset, model_step, thermistor_t16

_TICKS_MOST = const(0xFFFF)


@hot
def report_cause(state: Ints, code: int, value: int) -> int:
    """Note a cause with its value; return the cause that stands in this tick.

    The first stays, except that one which allows damping gives way to one which does not.
    """
    if state[S_CAUSE] == FAULT_NONE or (damps_first(state[S_CAUSE]) and damps_first(code) == 0):
        state[S_CAUSE] = code
        state[S_CAUSE_VALUE] = value
    return state[S_CAUSE]


@hot
def protect_motion(foc, cfg, state: Ints, io: Ints) -> int:
    """Look for causes once a millisecond, the most dangerous first; return S_CAUSE.

    Times: over-current and emergency stop 1 tick, voltages K_BUS_TICKS, a lost encoder K_BAD_TICKS,
    disagreement K_DISAGREE_TICKS, current sum K_SUM_TICKS, stall K_STALL_TICKS.
    """
    state[S_CAUSE] = FAULT_NONE
    state[S_CAUSE_VALUE] = 0
    if io[IO_E_STOP]:
        report_cause(state, FAULT_EMERGENCY_STOP, 0)
    if io[IO_HARDWARE_FAULT]:
        report_cause(state, io[IO_HARDWARE_FAULT], io[IO_HARDWARE_VALUE])
    _check_current(foc, cfg, state)
    _check_encoders(foc, cfg, state)
    _check_bus(cfg, state)
    _check_motion(cfg, state)
    _check_stall(cfg, state)
    if state[S_SLOW_CAUSE]:
        report_cause(state, state[S_SLOW_CAUSE], state[S_SLOW_VALUE])
    if state[S_RAISED]:
        report_cause(state, state[S_RAISED], state[S_RAISED_VALUE])
        state[S_RAISED] = FAULT_NONE
    return state[S_CAUSE]


@hot
def count_ticks(ticks: int, present: int) -> int:
    """Return ticks + 1 while ``present`` is not 0 (65535 at most), 0 when it is not."""
    if present == 0:
        return 0
    if ticks < _TICKS_MOST:
        return ticks + 1
    return ticks


@hot
def gather_heat(foc: Ints, state: Ints) -> int:
    """Add this tick's i^2/256 to the sum the slow tick takes; return the sum. 300 ticks at most: below 2^30."""
    if state[S_HEAT_TICKS] >= 300:
        return state[S_HEAT_SUM]
    state[S_HEAT_SUM] += foc[F_I_D] * foc[F_I_D] + foc[F_I_Q] * foc[F_I_Q] >> 8
    state[S_HEAT_TICKS] += 1
    return state[S_HEAT_SUM]


@hot
def protect_slow(cfg, state: Ints, io, curve) -> int:
    """Read both temperatures, advance the models and set S_DERATE, S_SLOW_LIMITS, S_SLOW_CAUSE; return S_DERATE (Q15).

    Ten times a second. The current's share falls linearly from 1 at the derating temperature to 0 at
    the cut, winding and MCU alike; at the cut it is also a fault. An open or shorted sensor is a fault.
    """
    state[S_SLOW_CAUSE] = FAULT_NONE
    state[S_SLOW_LIMITS] = 0
    winding_known = _read_winding(cfg, state, io, curve)
    _read_mcu(cfg, state, io)
    square = 0
    if state[S_HEAT_TICKS] > 0:
        square = state[S_HEAT_SUM] // state[S_HEAT_TICKS]
    state[S_HEAT_SUM] = 0
    state[S_HEAT_TICKS] = 0
    model = model_step(cfg, state, square)
    if model > state[S_WINDING] or winding_known == 0:
        state[S_WINDING] = model
    state[S_DERATE] = _derate(cfg, state, square)
    return state[S_DERATE]


@hot
def _slow_cause(state: Ints, code: int, value: int) -> int:
    """Keep the first cause of slowing down, with its number; return ``code``."""
    if state[S_SLOW_CAUSE] == FAULT_NONE:
        state[S_SLOW_CAUSE] = code
        state[S_SLOW_VALUE] = value
    return code


@hot
def _read_winding(cfg: Ints, state: Ints, io: Ints, curve) -> int:
    """Set S_WINDING from the thermistor; return 0 if it is open or shorted."""
    raw = io[IO_THERMISTOR_RAW]
    if raw >= cfg[K_OPEN_RAW]:
        _slow_cause(state, FAULT_THERMISTOR_OPEN, raw)
        return 0
    if raw <= cfg[K_SHORT_RAW]:
        _slow_cause(state, FAULT_THERMISTOR_SHORT, raw)
        return 0
    state[S_WINDING] = thermistor_t16(curve, raw)
    if state[S_THERMAL_STARTED] == 0:
        state[S_THERMAL_STARTED] = 1
        model_reset(state, state[S_WINDING])
    return 1


@hot
def _read_mcu(cfg: Ints, state: Ints, io: Ints) -> int:
    raw = io[IO_MCU_RAW]
    state[S_MCU] = mcu_t16(raw, cfg[K_MCU_CAL1], cfg[K_MCU_CAL2])
    if raw <= 0 or raw >= 4095 or cfg[K_MCU_CAL1] == cfg[K_MCU_CAL2]:
        _slow_cause(state, FAULT_MCU_SENSOR, raw)
    return state[S_MCU]


@hot
def _derate(cfg: Ints, state: Ints, square: int) -> int:
    """Return the share of the largest current that temperatures and I2t leave, in Q15, with its flags and faults."""
    share = fall_q15(state[S_WINDING], cfg[K_WINDING_DERATE], cfg[K_WINDING_CUT])
    if share < 0x8000:
        state[S_SLOW_LIMITS] = state[S_SLOW_LIMITS] | LIMIT_WINDING_TEMPERATURE
    if state[S_WINDING] >= cfg[K_WINDING_CUT]:
        _slow_cause(state, FAULT_WINDING_HOT, state[S_WINDING])
    mcu = fall_q15(state[S_MCU], cfg[K_MCU_DERATE], cfg[K_MCU_CUT])
    if mcu < 0x8000:
        state[S_SLOW_LIMITS] = state[S_SLOW_LIMITS] | LIMIT_MCU_TEMPERATURE
    if state[S_MCU] >= cfg[K_MCU_CUT]:
        _slow_cause(state, FAULT_MCU_HOT, state[S_MCU])
    if mcu < share:
        share = mcu
    left = _i2t_share(cfg, state, square)
    if left < share:
        share = left
    return share


@hot
def _i2t_share(cfg: Ints, state: Ints, square: int) -> int:
    excess = i2t_step(cfg, state, square)
    most = cfg[K_CURRENT_MAX]
    lasting = cfg[K_I2T_CURRENT]
    if excess >= 0x8000 or lasting >= most or most < 1:
        return 0x8000
    state[S_SLOW_LIMITS] = state[S_SLOW_LIMITS] | LIMIT_I2T
    return (lasting << 15) // most + ((most - lasting) * excess) // most


@hot
def _check_current(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Trip, voltage limit, sum of the phases; the last only under torque, so that calibration can measure offsets."""
    if foc[F_TRIPPED]:
        length = isqrt(foc[F_I_D] * foc[F_I_D] + foc[F_I_Q] * foc[F_I_Q])
        report_cause(state, FAULT_OVER_CURRENT, length)
        foc[F_TRIPPED] = 0
    if foc[F_LIMITED]:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_VOLTAGE
        foc[F_LIMITED] = 0
    wrong = current_sum(foc)
    present = 0
    if foc[F_MASKED] == 0 and (wrong > cfg[K_SUM_LIMIT] or wrong < -cfg[K_SUM_LIMIT]):
        present = 1
    state[S_SUM_TICKS] = count_ticks(state[S_SUM_TICKS], present)
    if state[S_SUM_TICKS] >= cfg[K_SUM_TICKS] and state[S_TORQUE] != TORQUE_OFF and state[S_MODE] != MODE_CALIBRATING:
        report_cause(state, FAULT_CURRENT_SENSE, wrong)
    return present


@hot
def _check_encoders(foc: Ints, cfg: Ints, state: Ints) -> int:
    """After any fault of an encoder the position is not trusted: the joint must be homed again."""
    glitches = foc[F_GLITCHES]
    foc[F_GLITCHES] = 0
    if glitches >= cfg[K_GLITCH_STEPS]:
        state[S_BAD_TICKS] = count_ticks(state[S_BAD_TICKS], 1)
    elif state[S_BAD_TICKS] > 0:
        state[S_BAD_TICKS] -= 1
    if state[S_SHIFTED] and state[S_HOMED]:
        report_cause(state, FAULT_POSITION_RANGE, state[S_TURNS])
        state[S_HOMED] = 0
    if state[S_DISAGREE_TICKS] >= cfg[K_DISAGREE_TICKS]:
        report_cause(state, FAULT_ENCODER_DISAGREE, state[S_JOINT_ERROR])
        state[S_HOMED] = 0
    if state[S_BAD_TICKS] >= cfg[K_BAD_TICKS]:
        report_cause(state, FAULT_ENCODER_LOST, glitches)
        state[S_HOMED] = 0
        if state[S_TORQUE] == TORQUE_OFF:
            encoder_resync(foc, state)
    return glitches


@hot
def _check_bus(cfg: Ints, state: Ints) -> int:
    bus = state[S_BUS]
    present = 0
    if bus < cfg[K_UNDER]:
        present = 1
    state[S_UNDER_TICKS] = count_ticks(state[S_UNDER_TICKS], present)
    if state[S_UNDER_TICKS] >= cfg[K_BUS_TICKS]:
        report_cause(state, FAULT_UNDER_VOLTAGE, bus)
    present = 0
    if bus > cfg[K_OVER]:
        present = 1
    state[S_OVER_TICKS] = count_ticks(state[S_OVER_TICKS], present)
    if state[S_OVER_TICKS] >= cfg[K_BUS_TICKS]:
        report_cause(state, FAULT_OVER_VOLTAGE, bus)
    return bus


@hot
def _check_motion(cfg: Ints, state: Ints) -> int:
    """Over-speed in any state; beyond the hard position limit only when driving further out."""
    rate = state[S_VELOCITY]
    if rate > cfg[K_RATE_TRIP] or rate < -cfg[K_RATE_TRIP]:
        report_cause(state, FAULT_OVER_SPEED, rate)
    if state[S_TORQUE] != TORQUE_DRIVE or state[S_HOMED] == 0:
        return 0
    position = state[S_POSITION]
    if rate > 0 and position > cfg[K_POSITION_MAX] + cfg[K_POSITION_MARGIN]:
        report_cause(state, FAULT_POSITION_LIMIT, position)
    if rate < 0 and position < cfg[K_POSITION_MIN] - cfg[K_POSITION_MARGIN]:
        report_cause(state, FAULT_POSITION_LIMIT, position)
    return rate


@hot
def _check_stall(cfg: Ints, state: Ints) -> int:
    """A stall is: asked to move, all the current there is, and standing. Holding a load is none."""
    slow = cfg[K_STALL_RATE]
    asked = state[S_RATE_REF]
    if asked < 0:
        asked = -asked
    rate = state[S_VELOCITY]
    push = state[S_CURRENT_REF]
    if push < 0:
        push = -push
    if rate < 0:
        rate = -rate
    stalled = 0
    if state[S_MODE] == MODE_POSITION or state[S_MODE] == MODE_VELOCITY:
        stalled = 1
    if asked <= slow + slow or rate >= slow or push < state[S_CURRENT_LIMIT] or state[S_TORQUE] != TORQUE_DRIVE:
        stalled = 0
    if stalled:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_STALL
    state[S_STALL_TICKS] = count_ticks(state[S_STALL_TICKS], stalled)
    if state[S_STALL_TICKS] >= cfg[K_STALL_TICKS]:
        report_cause(state, FAULT_STALL, state[S_CURRENT_REF])
    return stalled
