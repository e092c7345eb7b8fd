"""The joint's parameters: where each lives in the blocks, and how they are kept over a power cycle (settings.py).

Kept are: magic, protocol hash, number of records, then (id, value) pairs, then CRC-32, all little-endian.
"""

import binascii
import struct

from shared.joint.calibration import set_commutation
from shared.joint.current import set_loop
from shared.joint.thermal import CURVE_SIZE
from shared.record import set_at, value_at
from shared.runtime import const
from shared.wire.access import is_stored
from shared.wire.names import PROTOCOL_HASH
from shared.wire.parameters import (
    PARAMETER_CURRENT_KP,
    PARAMETER_DEFAULT,
    PARAMETER_HIGH,
    PARAMETER_LOW,
    PARAMETER_NODE_ID,
    PARAMETER_POLE_PAIRS,
    PARAMETER_THERMISTOR_RAW,
    PARAMETERS,
)

from .joint_control import Control

LOADED = const(1)
MISSING = const(2)
BROKEN = const(3)

KEY = "joint"
_MAGIC = const(0x4A50)
_HEAD = "<HHH"
_RECORD = "<Hi"


class Parameters:
    """Reads and writes the stored kind of parameters in the blocks of ``control``; ``node`` is the first of them."""

    def __init__(self, control: Control, journal):
        self._control = control
        self._journal = journal
        self.node = 0

    def get(self, parameter):
        """Return the raw value of a stored parameter."""
        if parameter == PARAMETER_NODE_ID:
            return self.node
        if parameter < PARAMETER_THERMISTOR_RAW:
            return value_at(self._control.loop_settings, parameter - PARAMETER_CURRENT_KP)
        if parameter < PARAMETER_THERMISTOR_RAW + CURVE_SIZE:
            return self._control.curve[parameter - PARAMETER_THERMISTOR_RAW]
        return value_at(self._control.settings, parameter - PARAMETER_POLE_PAIRS)

    def put(self, parameter, value):
        """Set one stored parameter; its limits are the caller's to check."""
        control = self._control
        if parameter == PARAMETER_NODE_ID:
            self.node = value
        elif parameter < PARAMETER_THERMISTOR_RAW:
            set_at(control.loop_settings, parameter - PARAMETER_CURRENT_KP, value)
            set_loop(control.loop, control.loop_settings)
        elif parameter < PARAMETER_THERMISTOR_RAW + CURVE_SIZE:
            control.curve[parameter - PARAMETER_THERMISTOR_RAW] = value
        else:
            set_at(control.settings, parameter - PARAMETER_POLE_PAIRS, value)
            if control.armed() == 0:
                set_commutation(control.loop, control.settings)

    def take(self, values):
        """Set every stored parameter but the node, ``values`` by id from current_kp on; limits are the caller's."""
        for at, value in enumerate(values):
            self.put(PARAMETER_CURRENT_KP + at, value)

    def defaults(self):
        """Set every stored parameter but the node to that of a fresh board."""
        self.take(PARAMETER_DEFAULT[PARAMETER_CURRENT_KP:])

    def load(self):
        """Read what is kept over the defaults; return LOADED, MISSING, or BROKEN with the defaults in place."""
        self.defaults()
        data = self._journal.get(KEY)
        if data is None:
            return MISSING
        if not _sound(data):
            return BROKEN
        for at in range(struct.calcsize(_HEAD), len(data) - 4, struct.calcsize(_RECORD)):
            parameter, value = struct.unpack_from(_RECORD, data, at)
            if not is_stored(parameter) or not PARAMETER_LOW[parameter] <= value <= PARAMETER_HIGH[parameter]:
                self.defaults()
                self.node = 0
                return BROKEN
            self.put(parameter, value)
        return LOADED

    def save(self):
        """Keep all stored parameters; return 1, or 0 if that failed: then the old ones are still kept."""
        return self._journal.put(KEY, self._packed())

    def _packed(self):
        stored = [parameter for parameter in range(PARAMETERS) if is_stored(parameter)]
        data = struct.pack(_HEAD, _MAGIC, PROTOCOL_HASH, len(stored))
        for parameter in stored:
            data += struct.pack(_RECORD, parameter, self.get(parameter))
        return data + struct.pack("<I", binascii.crc32(data))


def _sound(data):
    head = struct.calcsize(_HEAD)
    if len(data) < head + 4:
        return False
    magic, protocol, count = struct.unpack_from(_HEAD, data, 0)
    if magic != _MAGIC or protocol != PROTOCOL_HASH or len(data) != head + count * struct.calcsize(_RECORD) + 4:
        return False
    return struct.unpack_from("<I", data, len(data) - 4)[0] == binascii.crc32(data[:-4])
