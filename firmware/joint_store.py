"""The joint's parameters: where each lives in the blocks, and how they are kept over a power cycle (settings.py).

Kept are: magic, node, number of records, then (key, value) pairs, then CRC-32, all little-endian. A key stands for a
parameter's name, unit and scale, so that another firmware finds those that it knows too.
"""

import binascii
import struct

from shared.joint.bend import set_bend
from shared.joint.cogging import set_waves
from shared.joint.commutation import set_commutation
from shared.joint.current import keep_gains, set_loop
from shared.joint.thermal import CURVE_SIZE
from shared.record import set_at, value_at
from shared.runtime import const
from shared.wire.access import is_stored
from shared.wire.framing import NODES
from shared.wire.parameters import (
    PARAMETER_BEND_COS1,
    PARAMETER_CURRENT_KP,
    PARAMETER_DEFAULT,
    PARAMETER_HIGH,
    PARAMETER_KEY,
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
_MAGIC = const(0x4A51)
_HEAD = "<HHH"
_RECORD = "<ii"


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
            keep_gains(self._control.loop, self._control.loop_settings)
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
            if parameter >= PARAMETER_BEND_COS1:
                set_bend(control.loop, control.settings)
                set_waves(control.loop, control.settings)
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
        """Read what is kept over the defaults; return LOADED, MISSING, or BROKEN with the defaults in place.

        A parameter that was not kept has its default; what was kept of one that is no more is passed over. One out of
        its range is BROKEN; the node stays nevertheless.
        """
        self.defaults()
        data = self._journal.get(KEY)
        if data is None:
            return MISSING
        if not _sound(data):
            return BROKEN
        self.node = struct.unpack_from(_HEAD, data, 0)[1]
        parameter = 0
        for at in range(struct.calcsize(_HEAD), len(data) - 4, struct.calcsize(_RECORD)):
            key, value = struct.unpack_from(_RECORD, data, at)
            parameter = _parameter_of(key, parameter)
            if not is_stored(parameter):
                continue
            if not PARAMETER_LOW[parameter] <= value <= PARAMETER_HIGH[parameter]:
                self.defaults()
                return BROKEN
            self.put(parameter, value)
        return LOADED

    def save(self):
        """Keep all stored parameters; return 1, or 0 if that failed: then the old ones are still kept."""
        return self._journal.put(KEY, self._packed())

    def _packed(self):
        stored = [parameter for parameter in range(1, PARAMETERS) if is_stored(parameter)]
        data = struct.pack(_HEAD, _MAGIC, self.node, len(stored))
        for parameter in stored:
            data += struct.pack(_RECORD, PARAMETER_KEY[parameter], self.get(parameter))
        return data + struct.pack("<I", binascii.crc32(data))


def _parameter_of(key, near):
    """Return the parameter that is kept under a key, -1 for none; they are looked for from ``near`` on."""
    for way in range(PARAMETERS):
        parameter = (near + way) % PARAMETERS
        if PARAMETER_KEY[parameter] == key:
            return parameter
    return -1


def _sound(data):
    head = struct.calcsize(_HEAD)
    if len(data) < head + 4:
        return False
    magic, node, count = struct.unpack_from(_HEAD, data, 0)
    if magic != _MAGIC or node > NODES or len(data) != head + count * struct.calcsize(_RECORD) + 4:
        return False
    return struct.unpack_from("<I", data, len(data) - 4)[0] == binascii.crc32(data[:-4])
