"""Float twin of the cyclic frames of shared/wire/codec.py: physical values, struct; also for MicroPython."""

import struct

_DEG, _DEG_S, _AMPERE = 360.0 / 65536, 360.0 / 4096, 1.0 / 4096
NO_CHANGE = -32768


def _raw(value, unit):
    """Nearest raw value within +-32767; None is the value that is not there."""
    if value is None:
        return NO_CHANGE
    return int(max(-32767, min(32767, round(value / unit))))


def _value(raw, unit):
    return None if raw == NO_CHANGE else raw * unit


def encode_position_group(values_deg):
    return struct.pack("<4h", *[_raw(value, _DEG) for value in values_deg])


def decode_position_group(data):
    return [_value(raw, _DEG) for raw in struct.unpack("<4h", data)]


def encode_reply(position_deg, velocity_deg_s, current_a):
    return struct.pack("<3h", _raw(position_deg, _DEG), _raw(velocity_deg_s, _DEG_S), _raw(current_a, _AMPERE))


def decode_reply(data):
    position, velocity, current = struct.unpack("<3h", data)
    return _value(position, _DEG), _value(velocity, _DEG_S), _value(current, _AMPERE)
