"""shared/joint: the functions of plain numbers, each over its stated range."""


from shared.joint import cascade, encoder, faults, feed, profile, protection, report, svpwm, thermal
from shared.joint.layout import JointState

from .draw import INT16, INT30, SHARE, UNIT, Range
from .joint_robot import CURVE, SIGN
from .probe import Probe

GAIN14 = Range(0, 16383)
HALF30 = Range(-(1 << 29), 1 << 29)
ADC = Range(0, 4095)
ACCEL = Range(0, 65535)
RATE_MAX = Range(1, (1 << 18) - 1)
RATE = Range(-(1 << 18) + 1, (1 << 18) - 1)
TARGET = Range(-(1 << 28), 1 << 28)
DISTANCE = Range(0, (1 << 29) - 1)
STATE = JointState()


def _order(values, dice):
    if values[1] * 2 > values[2]:
        values[1] = values[2] >> 1


def _profile(values, dice):
    """A trajectory somewhere, faster than allowed or not; the target's own rate within the limit."""

    STATE.profile = dice.bits(29) - (1 << 28) if dice.bits(1) else values[1] + dice.bits(12) - 2048
    STATE.profile_rate = dice.bits(18) - (1 << 17)
    if values[2] > values[4] or values[2] < -values[4]:
        values[2] = values[4]


def _slewing(values, dice):

    STATE.profile_rate = dice.bits(19) - (1 << 18)


PROBES = (
    Probe(svpwm, "shape_pulse", (Range(1 - (1 << 29), (1 << 29) - 1), Range(0, 300), Range(600, 16800)), fit=_order),
    Probe(faults, "damps_first", (INT30,)),
    Probe(feed, "bus_voltage", (ADC, Range(0, 1 << 17))),
    Probe(feed, "dead_time_voltage", (UNIT, SHARE, Range(0, 4000))),
    Probe(encoder, "wrap_count", (HALF30,)),
    Probe(encoder, "position_of", (INT30, Range(0, 16383), Range(0, 16383), SIGN)),
    Probe(cascade, "position_from_wire", (Range(-65536, 65536), GAIN14)),
    Probe(cascade, "rate_from_wire", (INT16, SHARE)),
    Probe(cascade, "current_from_wire", (INT16, SHARE)),
    Probe(report, "position_to_wire", (INT30, Range(-5, 16382))),
    Probe(report, "report_temperature", (INT30,)),
    Probe(protection, "count_above", (Range(0, 65535), INT30, INT30)),
    Probe(profile, "braking_rate", (DISTANCE, ACCEL, RATE_MAX)),
    Probe(profile, "profile_reset", (STATE, Range(-(1 << 21) + 1, (1 << 21) - 1), INT30), watch=(STATE,)),
    Probe(profile, "profile_step", (STATE, TARGET, RATE, Range(1, 65535), RATE_MAX), watch=(STATE,), fit=_profile),
    Probe(profile, "slew_rate", (STATE, Range(-(1 << 19), 1 << 19), ACCEL), watch=(STATE,), fit=_slewing),
    Probe(thermal, "thermistor_t16", (CURVE, Range(-5, 4200))),
    Probe(thermal, "mcu_t16", (ADC, ADC, ADC)),
    Probe(thermal, "copper_share", (INT16,)),
    Probe(thermal, "scaled", (Range(-(1 << 26), (1 << 26) - 1), GAIN14, Range(13, 30))),
)
