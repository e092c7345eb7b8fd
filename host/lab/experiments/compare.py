"""Means, standard deviations, and Student's t-test from them, two-sided, equal variances, as paper A used it."""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Sample:
    """A series of trials: their number, mean and sample standard deviation."""

    n: int
    mean: float
    sd: float

    def as_json(self) -> dict[str, float]:
        """Return mean and standard deviation, six significant digits."""
        return {"mean": float(f"{self.mean:.6g}"), "sd": float(f"{self.sd:.6g}")}


def sample(values: Sequence[float]) -> Sample:
    """Return the sample of some values; the deviation of a single one is 0."""
    sd = statistics.stdev(values) if len(values) > 1 else 0.0
    return Sample(len(values), statistics.fmean(values), sd)


def published(n: int, quantity: dict[str, float]) -> Sample:
    """Return a paper's figure as a sample."""
    return Sample(n, quantity["mean"], quantity["sd"])


def t_test(first: Sample, second: Sample) -> float | None:
    """Return the two-sided p-value for equal means; None if nothing varies or n is too small."""
    from scipy import stats

    if min(first.n, second.n) < 2 or first.sd + second.sd <= 1e-9 * (abs(first.mean) + abs(second.mean)):
        return None
    p = stats.ttest_ind_from_stats(first.mean, first.sd, first.n, second.mean, second.sd, second.n).pvalue
    return float(f"{float(p):.4g}") if math.isfinite(p) else None
