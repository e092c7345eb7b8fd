"""ADC1 to ADC3: RM0090 section 13. Single-shot sequences, injected before regular; no DMA, no dual or triple mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .pin_table import ANALOG_PIN, INTERNAL
from .registers import Peripheral, Register
from .timeline import Due, cycles_of_ns

EOC, JEOC, JSTRT, STRT, OVR = (1 << n for n in (1, 2, 3, 4, 5))
EOCIE, JEOCIE, SCAN, JAUTO, OVRIE = (1 << n for n in (5, 7, 8, 10, 26))
ADON, CONT, DMA, EOCS, ALIGN, JSWSTART, SWSTART = (1 << n for n in (0, 1, 8, 10, 11, 22, 30))
ADC_IRQ = 18
SAMPLING = (3, 15, 28, 56, 84, 112, 144, 480)  # 13.13.4, 13.13.5: cycles of ADCCLK
BITS = (12, 10, 8, 6)  # 13.13.2 RES: as many cycles for the conversion (13.7)
# Tables 68 and 69: external triggers of regular and injected groups.
REGULAR_LINES = [
    "TIM1_CC1", "TIM1_CC2", "TIM1_CC3", "TIM2_CC2", "TIM2_CC3", "TIM2_CC4",
    "TIM2_TRGO", "TIM3_CC1", "TIM3_TRGO", "TIM4_CC4", "TIM5_CC1", "TIM5_CC2",
    "TIM5_CC3", "TIM8_CC1", "TIM8_TRGO", "EXTI11",
]  # fmt: skip
INJECTED_LINES = [
    "TIM1_CC4", "TIM1_TRGO", "TIM2_CC1", "TIM2_TRGO", "TIM3_CC2", "TIM3_CC4",
    "TIM4_CC1", "TIM4_CC2", "TIM4_CC3", "TIM4_TRGO", "TIM5_CC4", "TIM5_TRGO",
    "TIM8_CC2", "TIM8_CC3", "TIM8_CC4", "EXTI15",
]  # fmt: skip
# DS8626, ADC (ADC), 69 (temperature sensor), 71 (VBAT), 72 (VREFINT).
MAX_HZ = 36_000_000
POWER_UP_NS = 3_000
LATENCY = {"injected": 3, "regular": 2}  # longest from trigger to sampling, cycles of ADCCLK
LEAST_SAMPLING_NS = {"TEMPERATURE": 10_000, "VREFINT": 10_000, "VBAT": 5_000}
SENSOR_START_NS = 10_000


@dataclass(frozen=True)
class Sample:
    """One conversion. It sampled some time from ``earliest`` to ``latest``; the model took the value at ``latest``."""

    adc: str
    group: str
    channel: int
    trigger: int
    earliest: int
    latest: int
    done: int
    counts: int


class AdcCommon(Peripheral):
    """The registers common to the three ADCs, 13.13.16 on."""

    write_sizes: ClassVar = (4,)
    registers: ClassVar = (
        Register("CSR", 0x00, 0, 0),
        Register("CCR", 0x04, 0, 0x00C3_EF1F),
        Register("CDR", 0x08, 0, 0),
    )

    def power_up(self) -> None:
        self.sensors_on_at = 0

    def clocked(self, register: str) -> bool:
        """Any of the three clock gates will do."""
        if any(not self.chip.rcc.why_not_clocked("APB2ENR", bit) for bit in (8, 9, 10)):
            return True
        return super().clocked(register)

    def read_CSR(self) -> int:
        return sum((adc.value["SR"] & 0x3F) << 8 * n for n, adc in enumerate(self.chip.adcs.values()))

    def write_CCR(self, old: int, new: int) -> None:
        if new & 0xEF1F:
            self.complain("CCR", "dual and triple modes and their DMA are not modelled")
        if new & ~old & 1 << 23:
            self.sensors_on_at = self.chip.now

    @property
    def clock_cycles(self) -> int:
        """Core cycles of one ADCCLK: PCLK2 / 2, 4, 6 or 8 (13.13.16 ADCPRE)."""
        return self.chip.rcc.apb2_divider * 2 * ((self.value["CCR"] >> 16 & 3) + 1)


class Adc(Peripheral):
    """One converter. ``samples`` holds every conversion."""

    write_sizes: ClassVar = (4,)
    interrupts: ClassVar = (ADC_IRQ,)
    registers: ClassVar = (
        Register("SR", 0x00, 0, 0, clear=0x3F),
        Register("CR1", 0x04, 0, 0x07C0_FFFF),
        Register("CR2", 0x08, 0, 0x7F7F_0F03),
        Register("SMPR1", 0x0C, 0, 0x07FF_FFFF),
        Register("SMPR2", 0x10, 0, 0x3FFF_FFFF),
        *(Register(f"JOFR{n}", 0x10 + 4 * n, 0, 0xFFF) for n in (1, 2, 3, 4)),
        Register("HTR", 0x24, 0xFFF, 0xFFF),
        Register("LTR", 0x28, 0, 0xFFF),
        Register("SQR1", 0x2C, 0, 0x00FF_FFFF),
        Register("SQR2", 0x30, 0, 0x3FFF_FFFF),
        Register("SQR3", 0x34, 0, 0x3FFF_FFFF),
        Register("JSQR", 0x38, 0, 0x003F_FFFF),
        *(Register(f"JDR{n}", 0x38 + 4 * n, 0, 0) for n in (1, 2, 3, 4)),
        Register("DR", 0x4C, 0, 0),
    )

    def power_up(self) -> None:
        self.samples: list[Sample] = []
        self.awaited: set[str] = set()
        self._idle()

    def _idle(self) -> None:
        self._due: Due | None = None
        self.busy = ""  # the group that converts
        self.waiting = ""  # the regular group, if an injected one has interrupted it
        self.rank, self.last_rank, self.trigger_at, self.next_start = 0, 0, 0, 0
        self.ready_at = 0
        self._resume_rank = 0

    def reset(self) -> None:
        self._stop()
        super().reset()
        self._arm()
        self._interrupt()

    def _stop(self) -> None:
        if self._due:
            self._due.cancel()
        self._idle()

    # -- triggers, 13.6 --

    def _arm(self) -> None:
        """Note which trigger lines would start a conversion."""
        word, self.awaited = self.value["CR2"], set()
        if word & ADON and word >> 20 & 3:
            self.awaited.add(INJECTED_LINES[word >> 16 & 15])
        if word & ADON and word >> 28 & 3:
            self.awaited.add(REGULAR_LINES[word >> 24 & 15])

    def edge(self, line: str, level: int) -> None:
        """An edge of a line that is waited for: JEXTEN and EXTEN take 1 rising, 2 falling, 3 both (13.6)."""
        word, way = self.value["CR2"], 1 if level else 2
        if word >> 20 & way and line == INJECTED_LINES[word >> 16 & 15]:
            self._trigger("injected")
        if word >> 28 & way and line == REGULAR_LINES[word >> 24 & 15]:
            self._trigger("regular")

    def _trigger(self, group: str) -> None:
        """An injected trigger resets a regular conversion, which starts again afterwards (13.3.9)."""
        if not self.clocked("CR2"):
            return
        if group == "regular" and self.value["SR"] & OVR and self.value["CR2"] & (DMA | EOCS):
            return  # after an overrun nothing is converted until OVR is cleared (13.8.2)
        if self.busy == group:
            self.complain("CR2", f"{group} trigger while that group still converts (13.3.9)")
        elif group == "regular" and self.busy:
            self.waiting = "regular"
        else:
            if self.busy:
                self.waiting = self.busy
                self._interrupted()
            self._begin(group)

    def _interrupted(self) -> None:
        if self._due:
            self._due.cancel()
        self.chip.note(self.name, f"regular conversion {self.rank + 1} reset by the injected group")
        self._resume_rank = self.rank

    def _begin(self, group: str, rank: int = 0) -> None:
        self._check_clock()
        self.busy, self.rank, self.trigger_at = group, rank, self.chip.now
        self.last_rank = self._length(group) - 1
        self.value["SR"] |= JSTRT if group == "injected" else STRT
        self.chip.note(self.name, f"{group} start")
        self.next_start = self.chip.now + LATENCY[group] * self.chip.adc_common.clock_cycles
        self._convert()

    def _check_clock(self) -> None:
        hertz = 168_000_000 / self.chip.adc_common.clock_cycles
        if hertz > MAX_HZ:
            self.complain("CCR", f"ADCCLK of {hertz:.0f} Hz is above 36 MHz (DS8626, ADC)")
        if self.chip.now < self.ready_at:
            self.complain("CR2", "conversion within t_STAB, 3 us, of ADON (13.3.6, DS8626, ADC)")

    # -- sequences, 13.3.3 --

    def _length(self, group: str) -> int:
        """Conversions of a group. Without SCAN only the first: said for regular groups, open for injected ones."""
        field = self.value["JSQR"] >> 20 & 3 if group == "injected" else self.value["SQR1"] >> 20 & 15
        if field and not self.value["CR1"] & SCAN:
            self.doubt(
                "CR1", f"{group} sequence of {field + 1} without SCAN: the model converts the first only (13.3.8)"
            )
            return 1
        return field + 1

    def _channel(self, group: str, rank: int) -> int:
        """JL + 1 injected conversions start at JSQ(4 - JL): with JL = 0 JSQ4 is the one (13.13.12)."""
        if group == "injected":
            return self.value["JSQR"] >> 5 * (3 - (self.value["JSQR"] >> 20 & 3) + rank) & 31
        register, place = ("SQR3", "SQR2", "SQR1")[rank // 6], rank % 6
        return self.value[register] >> 5 * place & 31

    def sampling_cycles(self, channel: int) -> int:
        """Return the sampling time of a channel in cycles of ADCCLK (SMPR1: 10 to 18, SMPR2: 0 to 9)."""
        if channel >= 10:
            return SAMPLING[self.value["SMPR1"] >> 3 * (channel - 10) & 7]
        return SAMPLING[self.value["SMPR2"] >> 3 * channel & 7]

    def _convert(self) -> None:
        """Ask to be called at the end of the sampling."""
        channel = self._channel(self.busy, self.rank)
        self._check_channel(channel)
        end = self.next_start + self.sampling_cycles(channel) * self.chip.adc_common.clock_cycles
        self._due = self.chip.at(end, lambda: self._sampled(channel))

    def _check_channel(self, channel: int) -> None:
        name = INTERNAL.get((self.name, channel))
        if name is None:
            if (self.name, channel) in ANALOG_PIN:
                self.chip.pins.check_analog(self.name, channel)
            else:
                self.complain("SQR", f"channel {channel} does not exist here")
            return
        common = self.chip.adc_common
        bit = 22 if name == "VBAT" else 23
        sampling = self.sampling_cycles(channel) * common.clock_cycles
        if not common.value["CCR"] >> bit & 1:
            self.complain("CCR", f"{name} converted with {'VBATE' if bit == 22 else 'TSVREFE'} off (13.10, 13.11)")
        elif bit == 23 and self.chip.now < common.sensors_on_at + cycles_of_ns(SENSOR_START_NS):
            self.complain("CCR", f"{name} converted within 10 us of TSVREFE (DS8626, temperature sensor)")
        if sampling < cycles_of_ns(LEAST_SAMPLING_NS[name]):
            self.complain(
                "SMPR1", f"{name} needs {LEAST_SAMPLING_NS[name] / 1000:g} us of sampling, has {sampling / 168:.2f} us"
            )

    def _sampled(self, channel: int) -> None:
        counts = self._measure(channel)
        bits = BITS[self.value["CR1"] >> 24 & 3]
        latest = self.chip.now
        done = latest + bits * self.chip.adc_common.clock_cycles
        earliest = self.trigger_at if self.rank == 0 else self.next_start
        sample = Sample(self.name, self.busy, channel, self.trigger_at, earliest, latest, done, counts)
        self._due = self.chip.at(done, lambda: self._converted(sample))

    def _measure(self, channel: int) -> int:
        """Ask the test's function for the value now; 0 if it gives none for the channel."""
        names = (f"{self.name}_IN{channel}", ANALOG_PIN.get((self.name, channel)), INTERNAL.get((self.name, channel)))
        for name in names:
            if name in self.chip.analog:
                value = round(self.chip.analog[name](self.chip.now))
                return min(max(value, 0), 4095) >> (12 - BITS[self.value["CR1"] >> 24 & 3])
        return 0

    def _converted(self, sample: Sample) -> None:
        self.samples.append(sample)
        self.chip.note(self.name, f"IN{sample.channel} = {sample.counts}")
        self._store(sample)
        if self.rank < self.last_rank:
            self.rank, self.next_start = self.rank + 1, self.chip.now
            self._convert()
        else:
            self._finished()

    def _store(self, sample: Sample) -> None:
        """Injected: minus JOFR, sign-extended (13.4); regular: EOC after each conversion only with EOCS."""
        left = self.value["CR2"] & ALIGN
        if sample.group == "injected":
            number = self.rank + 1
            signed = sample.counts - self.value[f"JOFR{number}"]
            self.value[f"JDR{number}"] = (signed << 3 if left else signed) & 0xFFFF
            return
        if self.value["SR"] & EOC and self.value["CR2"] & (EOCS | DMA):
            self.value["SR"] |= OVR
            self.complain("DR", "overrun: the last result had not been read (13.8.2)")
        else:
            self.value["DR"] = sample.counts << 4 if left else sample.counts
        if self.value["CR2"] & EOCS:
            self.value["SR"] |= EOC
        self._interrupt()

    def _finished(self) -> None:
        group, self.busy = self.busy, ""
        if group == "injected":
            self.value["SR"] |= JEOC
            self.chip.note(self.name, "JEOC")
        elif not self.value["CR2"] & EOCS:
            self.value["SR"] |= EOC
        self._interrupt()
        if group == "injected" and self.waiting:
            rank, self.waiting = self._resume_rank, ""
            self._begin("regular", rank)
            self._resume_rank = 0
        elif group == "regular" and self.value["CR1"] & JAUTO:
            self._begin("injected")
        elif group == "regular" and self.value["CR2"] & CONT:
            self._begin("regular")

    # -- registers, 13.13 --

    def _interrupt(self) -> None:
        """The three ADCs share one vector (13.12)."""
        flags, enables = self.value["SR"], self.value["CR1"]
        active = (flags & EOC and enables & EOCIE) or (flags & JEOC and enables & JEOCIE)
        self.chip.nvic.line(ADC_IRQ, self.name, bool(active or (flags & OVR and enables & OVRIE)))

    def write_SR(self, _old: int, _new: int) -> None:
        self._interrupt()

    def write_CR1(self, _old: int, new: int) -> None:
        if new & 0x00C0_1A00:
            self.complain("CR1", "analog watchdog and discontinuous modes are not modelled")
        self._interrupt()

    def read_DR(self) -> int:
        """Reading DR clears EOC (13.13.1)."""
        self.value["SR"] &= ~EOC
        self._interrupt()
        return self.value["DR"]

    def write_CR2(self, old: int, new: int) -> None:
        self.value["CR2"] = new & ~(JSWSTART | SWSTART)
        self._arm()
        if new & DMA:
            self.complain("CR2", "DMA is not modelled")
        if new & ~old & ADON:
            self.ready_at = self.chip.now + round(cycles_of_ns(POWER_UP_NS))
        if old & ~new & ADON:
            self._stop()
        if new & (JSWSTART | SWSTART) and not old & new & ADON:
            self.complain("CR2", "started while ADON is 0: nothing is converted (13.13.3)")
            return
        if new & JSWSTART:
            self._trigger("injected")
        if new & SWSTART:
            self._trigger("regular")

    def _sequence_written(self, name: str, old: int, new: int) -> None:
        if self.busy and old != new:
            self.complain(name, "changed during a conversion, which resets it (13.3.3)")

    def write_JSQR(self, old: int, new: int) -> None:
        if self.busy == "injected":
            self._sequence_written("JSQR", old, new)

    def write_SQR1(self, old: int, new: int) -> None:
        if self.busy == "regular":
            self._sequence_written("SQR1", old, new)

    def write_SQR3(self, old: int, new: int) -> None:
        if self.busy == "regular":
            self._sequence_written("SQR3", old, new)

    def write_SMPR1(self, old: int, new: int) -> None:
        self._sequence_written("SMPR1", old, new)

    def write_SMPR2(self, old: int, new: int) -> None:
        self._sequence_written("SMPR2", old, new)
