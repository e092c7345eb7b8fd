"""A winding's thermistor behind its pull-up: its curve as the joint keeps it, and whether the board can read it."""

from bisect import bisect_left
from functools import cache
from itertools import accumulate
from math import ceil, exp, inf, log, sqrt
from typing import NamedTuple

from shared.joint.thermal import CURVE_POINTS, CURVE_SIZE, thermistor_t16

from .actuators import Bldc
from .joint_units import Board

PTC_PER_K = 0.0078  # silicon sensor, per K at 25 degrees C (typical datasheet value)
OPEN_RAW, SHORT_RAW = 4080, 16  # an open or shorted sensor reads an end, less the ADC's offset and gain error
CURVE_C = (-60.0, 250.0)  # ends of the curve; beyond, the ends' temperature
MUST_READ_C = (-20, 150)  # what protection needs: from a cold start to beyond most cut-offs
_E3_OHM = [m * 10**e for e in range(1, 6) for m in (1.0, 2.2, 4.7)]


class Part(NamedTuple):
    """The parts that a reading depends on; the thermistor goes to ground, the pull-up to the ADC's supply."""

    kind: str  # "ntc" or "ptc"
    ohm_25C: float
    beta_K: float
    pull_up_ohm: float

    def celsius(self, ohm: float) -> float:
        """Return the temperature of a resistance: R25 exp(B (1/T - 1/T25)), or a silicon sensor's straight line."""
        if self.kind == "ptc":
            return 25.0 + (ohm / self.ohm_25C - 1) / PTC_PER_K
        inverse = 1 / 298.15 + log(ohm / self.ohm_25C) / self.beta_K
        return 1 / inverse - 273.15 if inverse > 1e-4 else inf

    def counts(self, celsius: float) -> int:
        """Return the ADC's reading at a temperature."""
        if self.kind == "ptc":
            ohm = self.ohm_25C * (1 + PTC_PER_K * (celsius - 25))
        else:
            ohm = self.ohm_25C * exp(self.beta_K * (1 / (celsius + 273.15) - 1 / 298.15))
        return round(4096 * ohm / (ohm + self.pull_up_ohm))


def part_of(bldc: Bldc, board: Board) -> Part:
    """Return the robot file's thermistor on a board."""
    t = bldc.thermal
    return Part(t.thermistor, t.thermistor_25C_ohm, t.thermistor_beta_K, board.thermistor_pull_up_ohm)


@cache
def curve(part: Part) -> tuple[int, ...]:
    """Return CURVE_POINTS counts and the temperatures there, in 1/16 degree C: more points where the curve bends more.

    Between points a distance h apart a straight line is off by h^2 / 8 times the curve's second derivative: with as
    much of its root between any two points, the error is the same everywhere. Zeros if there is no curve to speak of.
    """
    celsius = {raw: part.celsius(part.pull_up_ohm * raw / (4096 - raw)) for raw in range(1, 4096)}
    inside = [raw for raw, value in celsius.items() if CURVE_C[0] <= value <= CURVE_C[1]]
    bends = list(accumulate(sqrt(abs(celsius[raw - 1] - 2 * celsius[raw] + celsius[raw + 1])) for raw in inside[1:-1]))
    if not bends:
        return (0,) * CURVE_SIZE
    places = [bisect_left(bends, bends[-1] * i / (CURVE_POINTS - 1)) for i in range(1, CURVE_POINTS - 1)]
    counts = [inside[0], *(inside[place + 1] for place in places), inside[-1]]
    return (*counts, *(round(16 * celsius[raw]) for raw in counts))


@cache
def worst_error_K(part: Part, most_C: int) -> float:
    """Return the largest error of the joint's reading, from -20 degrees C to ``most_C``.

    Curve, rounding and the ADC's resolution; infinite if a reading is one of an open or shorted sensor.
    """
    points, worst = list(curve(part)), 0.0  # the compiled core takes lists alone
    for tenths in range(10 * MUST_READ_C[0], 10 * most_C + 1, 2):
        celsius = tenths / 10
        raw = part.counts(celsius)
        if not SHORT_RAW < raw < OPEN_RAW:
            return inf
        worst = max(worst, abs(thermistor_t16(points, raw) / 16 - celsius))
    return worst


def refusal(bldc: Bldc, board: Board) -> str:
    """Return what to use instead if the board can't read the file's thermistor within a degree; else ""."""
    part, most_C = part_of(bldc, board), max(MUST_READ_C[1], ceil(bldc.thermal.winding_cutoff_C))
    if worst_error_K(part, most_C) <= 1:
        return ""
    good = [ohm for ohm in _E3_OHM if worst_error_K(part._replace(ohm_25C=ohm), most_C) <= 1]
    wanted = f"{good[0]:g} .. {good[-1]:g} ohm" if good else "another thermistor_beta_K: no resistance fits this one"
    return f"{wanted}, which the board with its pull-up of {part.pull_up_ohm:g} ohm reads within a degree"
