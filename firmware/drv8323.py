"""The DRV8323 gate driver over SPI (data sheet SLVSDJ3, section 8.6): 16 bits, mode 1, bit 15 read, 14 .. 11 address.

Every register written is read back; one that differs is the fault *gate driver setup* with its address.
"""

from shared.runtime import const

FAULT_STATUS_1 = const(0x00)
FAULT_STATUS_2 = const(0x01)
DRIVER_CONTROL = const(0x02)
GATE_DRIVE_HS = const(0x03)
GATE_DRIVE_LS = const(0x04)
OCP_CONTROL = const(0x05)
CSA_CONTROL = const(0x06)

DRIVER_READ = const(0x8000)
_CLEAR = const(0x01)  # CLR_FLT, clears itself

# (register, value): chosen; each field as the data sheet names it
SETTINGS = (
    (GATE_DRIVE_HS, 0x344),  # LOCK 011 unlocked, IDRIVEP 120 mA, IDRIVEN 240 mA
    (GATE_DRIVE_LS, 0x744),  # CBC, TDRIVE 4 us, the same currents
    (OCP_CONTROL, 0x119),  # dead time 100 ns, over-current latches after 4 us, at 0.75 V drain to source
    (CSA_CONTROL, 0x2C3),  # VREF/2 bidirectional, 40 V/V, over-current of the shunt at 1 V
    (DRIVER_CONTROL, 0x000),  # six PWM inputs
)


class Drv8323:
    """``exchange(word)`` sends 16 bits and returns those that come meanwhile, -1 for none. Nothing here allocates."""

    def __init__(self, exchange):
        self._exchange = exchange

    def read(self, register):
        """Return the 11 bits of a register, or -1."""
        word = self._exchange(DRIVER_READ | register << 11)
        return word if word < 0 else word & 0x7FF

    def write(self, register, value):
        """Write the 11 bits of a register."""
        self._exchange(register << 11 | value)

    def setup(self):
        """Clear faults, write all settings and read them back; return the first register that differs, -1 if none."""
        self.write(DRIVER_CONTROL, _CLEAR)
        for register, value in SETTINGS:
            self.write(register, value)
        return self.check()

    def check(self):
        """Read all settings again; return the first register that differs, -1 if none. For while disarmed."""
        for register, value in SETTINGS:
            if self.read(register) != value:
                return register
        return -1
