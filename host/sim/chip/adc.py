"""ADC1 to ADC3: RM0090 section 13. A conversion by software, and one that timer 1's TRGO injects, which comes first."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from .pin_table import ANALOG_PIN, TEMPERATURE
from .rcc import APB2_CYCLES
from .registers import Peripheral, Register
from .timeline import CORE_HZ, Due, cycles_of_ns

EOC, JEOC, JSTRT, STRT = (1 << n for n in (1, 2, 3, 4))
ADON, SWSTART = 1, 1 << 30
RISING_EDGE, OF_TRGO = 1 << 20, 1 << 16  # JEXTEN, JEXTSEL (table 69)
TSVREFE = 1 << 23
SAMPLING = (3, 15, 28, 56, 84, 112, 144, 480)  # 13.13.4, 13.13.5: cycles of ADCCLK
CONVERTING = 12  # the same (13.7), for 12 bits
# DS8626, ADC (ADC), 69 (temperature sensor).
MAX_HZ = 36_000_000
POWER_UP_NS = 3_000
LATENCY = {"injected": 3, "regular": 2}  # longest from trigger to sampling, cycles of ADCCLK
SENSOR_START_NS = SENSOR_SAMPLING_NS = 10_000


@dataclass(frozen=True)
class Sample:
    """One conversion. It sampled some time from ``trigger`` to ``latest``; the model took the value at ``latest``."""

    adc: str
    group: str
    channel: int
    trigger: int
    latest: int
    done: int
    counts: int


class AdcCommon(Peripheral):
    """The register common to the three ADCs, 13.13.16."""

    write_sizes: ClassVar = (4,)
    registers: ClassVar = (Register("CCR", 0x04, 0, TSVREFE | 3 << 16),)

    def power_up(self) -> None:
        self.sensor_on_at = 0

    def clocked(self, register: str) -> bool:
        """Any of the three clock gates will do."""
        if any(not self.chip.rcc.why_not_clocked("APB2ENR", bit) for bit in (8, 9, 10)):
            return True
        return super().clocked(register)

    def write_CCR(self, old: int, new: int) -> None:
        if new & ~old & TSVREFE:
            self.sensor_on_at = self.chip.now

    @property
    def clock_cycles(self) -> int:
        """Core cycles of one ADCCLK: PCLK2 / 2, 4, 6 or 8 (13.13.16 ADCPRE)."""
        return APB2_CYCLES * 2 * ((self.value["CCR"] >> 16 & 3) + 1)


class Adc(Peripheral):
    """One converter. ``samples`` holds every conversion."""

    write_sizes: ClassVar = (4,)
    registers: ClassVar = (
        Register("SR", 0x00, 0, 0, clear=0x3F),
        Register("CR1", 0x04, 0, 0),
        Register("CR2", 0x08, 0, ADON | OF_TRGO | RISING_EDGE | SWSTART),
        Register("SMPR1", 0x0C, 0, 0x07FF_FFFF),
        Register("SMPR2", 0x10, 0, 0x3FFF_FFFF),
        Register("SQR1", 0x2C, 0, 0),  # the sequences are of one conversion
        Register("SQR3", 0x34, 0, 0x1F),
        Register("JSQR", 0x38, 0, 0x1F << 15),  # 13.13.12: of one conversion JSQ4 is it
        Register("JDR1", 0x3C, 0, 0),
        Register("DR", 0x4C, 0, 0),
    )

    def power_up(self) -> None:
        self.samples: list[Sample] = []
        self._due = Due()
        for name, group in (("JSQR", "injected"), ("SQR3", "regular"), ("SMPR1", ""), ("SMPR2", "")):
            self.on_write(name, partial(self._written_while, group, name))

    def clear(self) -> None:
        self._due.cancel()
        self.busy = ""  # the group that converts
        self.waiting = False  # the regular conversion, for the injected one
        self.trigger_at, self.ready_at = 0, 0

    # -- triggers, 13.6 --

    def edge(self) -> None:
        """TRGO rises."""
        word = self.value["CR2"]
        if word & ADON and word & RISING_EDGE and word & OF_TRGO:
            self._trigger("injected")

    def _trigger(self, group: str) -> None:
        """An injected trigger resets a regular conversion, which starts again afterwards (13.3.9)."""
        if not self.clocked("CR2"):
            return
        if self.busy == group:
            self.complain("CR2", f"{group} trigger while that group still converts (13.3.9)")
        elif group == "regular" and self.busy:
            self.waiting = True
        else:
            if self.busy:
                self._due.cancel()
                self.waiting = True
                self.chip.note(self.name, "regular conversion reset by the injected one")
            self._begin(group)

    def _begin(self, group: str) -> None:
        """Start, and ask to be called at the end of the sampling."""
        clock_cycles = self.chip.adc_common.clock_cycles
        self._check_clock(CORE_HZ / clock_cycles)
        self.busy, self.trigger_at = group, self.chip.now
        self.value["SR"] |= JSTRT if group == "injected" else STRT
        self.chip.note(self.name, f"{group} start")
        channel = self.value["JSQR"] >> 15 if group == "injected" else self.value["SQR3"]
        sampling = self.sampling_cycles(channel) * clock_cycles
        self._check_channel(channel, sampling)
        end = self.chip.now + LATENCY[group] * clock_cycles + sampling
        self._due = self.chip.at(end, lambda: self._sampled(channel))

    def _check_clock(self, hertz: float) -> None:
        if hertz > MAX_HZ:
            self.complain("CCR", f"ADCCLK of {hertz:.0f} Hz is above 36 MHz (DS8626, ADC)")
        if self.chip.now < self.ready_at:
            self.complain("CR2", "conversion within t_STAB, 3 us, of ADON (13.3.6, DS8626, ADC)")

    def sampling_cycles(self, channel: int) -> int:
        """Return the sampling time of a channel in cycles of ADCCLK (SMPR1: 10 to 18, SMPR2: 0 to 9)."""
        if channel >= 10:
            return SAMPLING[self.value["SMPR1"] >> 3 * (channel - 10) & 7]
        return SAMPLING[self.value["SMPR2"] >> 3 * channel & 7]

    def _check_channel(self, channel: int, sampling: int) -> None:
        if (self.name, channel) == TEMPERATURE:
            self._check_sensor(sampling)
        elif (self.name, channel) in ANALOG_PIN:
            self.chip.pins.check_analog(self.name, channel)
        else:
            self.complain("SQR", f"channel {channel} does not exist here")

    def _check_sensor(self, sampling: int) -> None:
        common = self.chip.adc_common
        if not common.value["CCR"] & TSVREFE:
            self.complain("CCR", "TEMPERATURE converted with TSVREFE off (13.10)")
        elif self.chip.now < common.sensor_on_at + cycles_of_ns(SENSOR_START_NS):
            self.complain("CCR", "TEMPERATURE converted within 10 us of TSVREFE (DS8626, temperature sensor)")
        if sampling < cycles_of_ns(SENSOR_SAMPLING_NS):
            self.complain("SMPR1", f"TEMPERATURE needs 10 us of sampling, has {sampling / 168:.2f} us")

    def _sampled(self, channel: int) -> None:
        """The value is held: ask to be called when it is converted."""
        name = "TEMPERATURE" if (self.name, channel) == TEMPERATURE else ANALOG_PIN.get((self.name, channel))
        value = self.chip.analog[name](self.chip.now) if name in self.chip.analog else 0
        done = self.chip.now + CONVERTING * self.chip.adc_common.clock_cycles
        sample = Sample(self.name, self.busy, channel, self.trigger_at, self.chip.now, done,
                        min(max(round(value), 0), 4095))  # fmt: skip
        self._due = self.chip.at(done, lambda: self._converted(sample))

    def _converted(self, sample: Sample) -> None:
        self.samples.append(sample)
        self.chip.note(self.name, f"IN{sample.channel} = {sample.counts}")
        self.busy, injected = "", sample.group == "injected"
        self.value["JDR1" if injected else "DR"] = sample.counts
        self.value["SR"] |= JEOC if injected else EOC
        if injected and self.waiting:
            self.waiting = False
            self._begin("regular")

    # -- registers, 13.13 --

    def read_DR(self) -> int:
        """Reading DR clears EOC (13.13.1)."""
        self.value["SR"] &= ~EOC
        return self.value["DR"]

    def write_CR2(self, old: int, new: int) -> None:
        self.value["CR2"] = new & ~SWSTART
        if new & RISING_EDGE and not new & OF_TRGO:
            self.complain("CR2", "another trigger than TIM1_TRGO is not modelled")
        if new & ~old & ADON:
            self.ready_at = self.chip.now + round(cycles_of_ns(POWER_UP_NS))
        if old & ~new & ADON:
            self.clear()
        if new & SWSTART:
            if old & new & ADON:
                self._trigger("regular")
            else:
                self.complain("CR2", "started while ADON is 0: nothing is converted (13.13.3)")

    def _written_while(self, group: str, name: str, old: int, new: int) -> None:
        if self.busy and group in ("", self.busy) and old != new:
            self.complain(name, "changed during a conversion, which resets it (13.3.3)")
