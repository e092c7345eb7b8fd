"""What the factory wrote: unique number, flash size (RM0090 section 39), calibration of the sensors (DS8626)."""

from typing import ClassVar

from .registers import Peripheral, Register

# Typical: sensor 0.76 V at 25 degrees and 2.5 mV a degree, reference 1.21 V, counts at 3.3 V.
TS_CAL1, TS_CAL2, VREFINT_CAL = 959, 1207, 1502  # at 30 and 110 degrees


class Factory(Peripheral):
    """Read-only words; a test may put others into ``value``, which stay through a reset."""

    registers: ClassVar = (
        Register("UID0", 0x10, 0x0033_0041, 0),
        Register("UID1", 0x14, 0x3436_5107, 0),
        Register("UID2", 0x18, 0x3732_3537, 0),
        Register("FLASH_SIZE", 0x20, 1024 << 16, 0),  # the half-word at 0x1FFF7A22, in KiB
        Register("VREFINT_CAL", 0x28, VREFINT_CAL << 16, 0),  # the half-word at 0x1FFF7A2A
        Register("TS_CAL", 0x2C, TS_CAL1 | TS_CAL2 << 16, 0),
    )

    def reset(self) -> None:
        """A reset changes nothing here."""
