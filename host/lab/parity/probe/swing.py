"""shared/gait/swing.py: every sample of every swing length, with any re-timing."""

from shared.gait import swing

from .draw import Range
from .probe import Probe

PHASE = Range(0, 65536)

PROBES = (
    Probe(swing, "swing_phase_q16", (Range(-2, 16384), Range(1, 16383), PHASE, PHASE), vectors=2),
    Probe(swing, "swing_phase_q16:short", (Range(-2, 60), Range(1, 60), PHASE, PHASE), vectors=2),
    Probe(swing, "cycloid_q15", (PHASE,), vectors=2),
    Probe(swing, "lift_q15", (PHASE,), vectors=2),
)
