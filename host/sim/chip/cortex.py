"""What belongs to the Cortex-M4: NVIC, SCB, SysTick, cycle counter. PM0214 sections 4.3 to 4.5, RM0090 section 12."""

from __future__ import annotations

from typing import ClassVar

from .registers import Peripheral, Register
from .timeline import Due

INTERRUPTS = 82  # table 61, STM32F405
PRIORITY_BITS = 0xF0  # 16 levels (12.1.1)
PENDSV, SYSTICK = 14, 15
ENABLE, TICKINT, CLKSOURCE, COUNTFLAG = 1, 2, 4, 1 << 16
THREAD = 1 << 16  # less urgent than any exception


class Nvic(Peripheral):
    """Interrupt controller. Exceptions have numbers: interrupt + 16, SysTick 15, PendSV 14.

    The emulator asks ``waiting()``, then calls ``enter(exception)`` and ``leave()`` as it runs the handlers.
    """

    read_sizes: ClassVar = (1, 2, 4)
    write_sizes: ClassVar = (1, 2, 4)

    def power_up(self) -> None:
        self.reset()

    def reset(self) -> None:
        self.enabled: set[int] = set()
        self.pending: set[int] = set()
        self.active: list[int] = []
        self.priority: dict[int, int] = {}
        self.lines: dict[int, set[str]] = {}

    # -- the blocks' side --

    def line(self, interrupt: int, source: str, high: bool) -> None:
        """A block raises or drops its request. A raised line makes the interrupt pending (PM0214 4.3.9)."""
        exception = interrupt + 16
        users = self.lines.setdefault(exception, set())
        if not high:
            users.discard(source)
        else:
            if not users:
                self.pend(exception)
            users.add(source)

    def pend(self, exception: int) -> None:
        if exception not in self.pending:
            self.pending.add(exception)
            self.chip.note("NVIC", f"exception {exception} pending")

    # -- the core's side --

    def urgency(self, exception: int) -> int:
        """Return the priority, 0 the most urgent, without the sub-priority bits (PM0214 4.4.5 PRIGROUP)."""
        return self._priority(exception) >> self.chip.scb.subpriority_bits

    def _priority(self, exception: int) -> int:
        return self.chip.scb.priority(exception) if exception < 16 else self.priority.get(exception, 0)

    def waiting(self) -> list[int]:
        """Return the pending exceptions that may interrupt what runs now, most urgent first."""
        if not self.pending:
            return []
        running = min((self.urgency(exception) for exception in self.active), default=THREAD)
        ready = [e for e in self.pending if (e < 16 or e in self.enabled) and self.urgency(e) < running]
        return sorted(ready, key=lambda e: (self._priority(e), e))

    def enter(self, exception: int) -> None:
        """The core takes an exception."""
        self.pending.discard(exception)
        self.active.append(exception)
        self.chip.note("NVIC", f"exception {exception} entered")

    def leave(self) -> int:
        """The core returns from the exception it runs. A line still high makes it pending again."""
        exception = self.active.pop()
        self.chip.note("NVIC", f"exception {exception} left")
        if self.lines.get(exception):
            self.pend(exception)
        return exception

    # -- registers: ISER 0x000, ICER 0x080, ISPR 0x100, ICPR 0x180, IABR 0x200, IPR 0x300, STIR 0xE00 --

    def _set(self, offset: int) -> set[int]:
        banks: tuple[set[int], ...] = (self.enabled, self.enabled, self.pending, self.pending, set(self.active), set())
        return banks[offset >> 7]

    def read(self, offset: int, size: int) -> int:
        if offset >= 0x300:
            return sum(self.priority.get(16 + offset - 0x300 + n, 0) << 8 * n for n in range(size))
        first = 16 + (offset & 0x7C) * 8
        word = sum(1 << n for n in range(32) if first + n in self._set(offset))
        return word >> 8 * (offset & 3) & ((1 << 8 * size) - 1)

    def write(self, offset: int, value: int, size: int) -> None:
        if offset >= 0x300:
            for n in range(size):
                self._write_priority(16 + offset - 0x300 + n, value >> 8 * n & 0xFF)
            return
        first = 16 + (offset & 0x7F) * 8
        for n in range(8 * size):
            if value >> n & 1:
                self._write_bit(offset >> 7, first + n)

    def _write_priority(self, exception: int, value: int) -> None:
        if value & ~PRIORITY_BITS:
            self.complain("IPR", f"priority 0x{value:02X}: only the upper four bits exist (12.1.1)")
        self.priority[exception] = value & PRIORITY_BITS

    def _write_bit(self, bank: int, exception: int) -> None:
        if exception >= 16 + INTERRUPTS:
            self.complain("ISER", f"interrupt {exception - 16} does not exist (table 61)")
        elif bank == 0:
            self.enabled.add(exception)
        elif bank == 1:
            self.enabled.discard(exception)
        elif bank == 2:
            self.pend(exception)
        elif bank == 3:
            self.pending.discard(exception)
            if self.lines.get(exception):
                self.pend(exception)


class SystemControl(Peripheral):
    """System control block, PM0214 4.4."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("CPUID", 0x00, 0x410F_C241, 0),
        Register("ICSR", 0x04, 0, 0x9E00_0000, back=0x00C7_F9FF),
        Register("VTOR", 0x08, 0, 0x3FFF_FE00),
        Register("AIRCR", 0x0C, 0xFA05_0000),
        Register("SCR", 0x10, 0, 0x16),
        Register("CCR", 0x14, 0x200, 0x31B),
        Register("SHPR1", 0x18, 0, 0x00F0_F0F0),
        Register("SHPR2", 0x1C, 0, 0xF000_0000),
        Register("SHPR3", 0x20, 0, 0xF0F0_0000),
        Register("SHCSR", 0x24, 0, 0x0007_FD8B),
        Register("CFSR", 0x28),
        Register("HFSR", 0x2C),
        Register("DFSR", 0x30),
        Register("MMFAR", 0x34),
        Register("BFAR", 0x38),
        Register("AFSR", 0x3C),
        Register("CPACR", 0x88, 0, 0x00F0_0000),
        Register("MPU_TYPE", 0x90, 0x800, 0),
        Register("MPU_CTRL", 0x94, 0, 7),
        Register("MPU_RNR", 0x98, 0, 7),
        Register("MPU_RBAR", 0x9C),
        Register("MPU_RASR", 0xA0, 0, 0x173F_FF3F),
        Register("DEMCR", 0xFC, 0, 0x010F_07F1),
    )

    def priority(self, exception: int) -> int:
        """Return the priority of a system exception (SHPR1 to SHPR3)."""
        if exception < 4:
            return -1
        register, place = f"SHPR{exception // 4}", exception % 4
        return self.value[register] >> 8 * place & 0xFF

    @property
    def subpriority_bits(self) -> int:
        """Return how many low bits of a priority do not decide on interrupting (PRIGROUP)."""
        return (self.value["AIRCR"] >> 8 & 7) + 1

    def read_AIRCR(self) -> int:
        return 0xFA05_0000 | self.value["AIRCR"] & 0x700

    def write_AIRCR(self, old: int, new: int) -> None:
        """Needs the key 0x5FA; SYSRESETREQ resets the chip (PM0214 4.4.5)."""
        if new >> 16 != 0x5FA:
            self.refuse("AIRCR", old, "written without the key 0x5FA")
            return
        self.value["AIRCR"] = new & 0x700
        if new & 4:
            self.chip.reset("software")

    def write_ICSR(self, _old: int, new: int) -> None:
        self.value["ICSR"] = 0
        pending = self.chip.nvic.pending
        for exception, set_bit in ((PENDSV, 28), (SYSTICK, 26)):
            if new >> set_bit & 1:
                self.chip.nvic.pend(exception)
            if new >> (set_bit - 1) & 1:
                pending.discard(exception)

    def read_ICSR(self) -> int:
        nvic = self.chip.nvic
        active = nvic.active[-1] if nvic.active else 0
        waiting = sorted(nvic.pending, key=lambda e: (nvic._priority(e), e))
        word = active | (waiting[0] if waiting else 0) << 12 | (len(nvic.active) <= 1) << 11
        word |= (any(e >= 16 for e in nvic.pending)) << 22
        return word | (PENDSV in nvic.pending) << 28 | (SYSTICK in nvic.pending) << 26

    def write_VTOR(self, _old: int, new: int) -> None:
        self.chip.note(self.name, f"VTOR = 0x{new:08X}")


class FloatControl(Peripheral):
    """The floating-point unit's control registers, PM0214 4.6, and STIR, 4.3.8."""

    registers: ClassVar = (
        Register("STIR", 0x00, 0, 0x1FF, readable=False),
        Register("FPCCR", 0x34, 0xC000_0000, 0xC000_0000),
        Register("FPCAR", 0x38, 0, 0xFFFF_FFF8),
        Register("FPDSCR", 0x3C, 0, 0x07C0_0000),
    )

    def write_STIR(self, _old: int, new: int) -> None:
        self.chip.nvic.pend(16 + new)


class SysTick(Peripheral):
    """The core's timer, PM0214 4.5. It counts the core's clock or an eighth of it."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("ICTR", 0x04, 2, 0),
        Register("ACTLR", 0x08, 0, 0x307),
        Register("CTRL", 0x10, 0, 7, back=COUNTFLAG),
        Register("LOAD", 0x14, 0, 0x00FF_FFFF),
        Register("VAL", 0x18, 0, 0x00FF_FFFF),
        Register("CALIB", 0x1C, 0x4000_0000 | 21_000 - 1, 0),
    )

    def power_up(self) -> None:
        self._due: Due | None = None
        self.zero_at, self.left, self.counted = 0, 0, False

    def reset(self) -> None:
        self._stop()
        super().reset()
        self.zero_at, self.left, self.counted = 0, 0, False

    def _stop(self) -> None:
        if self._due:
            self._due.cancel()
            self._due = None

    @property
    def _step(self) -> int:
        return 1 if self.value["CTRL"] & CLKSOURCE else 8

    def _run(self, steps: int) -> None:
        """Reach zero ``steps`` steps from now."""
        self._stop()
        self.zero_at = self.chip.now + steps * self._step
        self._due = self.chip.at(self.zero_at, self._zero)

    def _zero(self) -> None:
        self.counted = True
        if self.value["CTRL"] & TICKINT:
            self.chip.nvic.pend(SYSTICK)
        if self.value["LOAD"]:
            self._run(self.value["LOAD"] + 1)

    def write_CTRL(self, old: int, new: int) -> None:
        if new & ~old & ENABLE:
            self._run(self.left or self.value["LOAD"] + 1)
        elif old & ~new & ENABLE:
            self.left = self._count()
            self._stop()

    def read_CTRL(self) -> int:
        """COUNTFLAG goes when it is read."""
        word, self.counted = self.value["CTRL"] | COUNTFLAG * self.counted, False
        return word

    def write_VAL(self, _old: int, _new: int) -> None:
        """Any write clears the counter and COUNTFLAG; the next step loads it."""
        self.counted, self.left = False, 0
        if self.value["CTRL"] & ENABLE:
            self._run(self.value["LOAD"] + 1)

    def _count(self) -> int:
        steps = max(self.zero_at - self.chip.now, 0) // self._step
        return 0 if steps > self.value["LOAD"] else steps

    def read_VAL(self) -> int:
        return self._count() if self.value["CTRL"] & ENABLE else self.left


class Dwt(Peripheral):
    """The cycle counter (ARMv7-M architecture, C1.8); it needs TRCENA in DEMCR, which is taken as set."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (Register("CTRL", 0x00, 0x4000_0000, 0x003F_FFFF), Register("CYCCNT", 0x04))

    def power_up(self) -> None:
        self.origin = 0

    def write_CTRL(self, old: int, new: int) -> None:
        """CYCCNTENA, bit 0: while it is 0 the counter stands."""
        if (old ^ new) & 1:
            self.value["CYCCNT"] = self._count(old)
            self.origin = self.chip.now

    def _count(self, control: int) -> int:
        return (self.value["CYCCNT"] + (self.chip.now - self.origin) * (control & 1)) & 0xFFFF_FFFF

    def read_CYCCNT(self) -> int:
        return self._count(self.value["CTRL"])

    def write_CYCCNT(self, _old: int, _new: int) -> None:
        self.origin = self.chip.now
