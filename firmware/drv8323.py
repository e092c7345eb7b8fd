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

_READ = const(0x80)
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
    """``spi`` is a machine.SPI, ``select`` the chip select pin (active low). Nothing here allocates after it exists."""

    def __init__(self, spi, select):
        self._spi = spi
        self._select = select
        self._out = bytearray(2)
        self._in = bytearray(2)
        select(1)

    def read(self, register):
        """Return the 11 bits of a register."""
        self._transfer(_READ | register << 3, 0)
        return (self._in[0] & 7) << 8 | self._in[1]

    def write(self, register, value):
        """Write the 11 bits of a register."""
        self._transfer(register << 3 | value >> 8, value & 0xFF)

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

    def faults(self):
        """Return fault status 1 (bits 0 .. 10) and 2 (bits 11 .. 21), each read once; 0 if there is none."""
        first = self.read(FAULT_STATUS_1)
        return first | self.read(FAULT_STATUS_2) << 11

    def _transfer(self, high, low):
        self._out[0] = high
        self._out[1] = low
        self._select(0)
        self._spi.write_readinto(self._out, self._in)
        self._select(1)
