"""Ticks are due at start + n / rate; what comes late is counted, what can't be made up is left out."""

import pytest

from host.control.pacer import Pacer, quantiles_ms


def tick(pacer, begin_s, end_s):
    pacer.begin(begin_s)
    return pacer.end(end_s)


def test_due_times_do_not_drift():
    pacer = Pacer(50, 100.0)
    for n in range(1000):
        assert pacer.due_s == pytest.approx(100.0 + n / 50, abs=1e-9)
        assert tick(pacer, pacer.due_s + 0.003, pacer.due_s + 0.010) == 0
    assert (pacer.ticks, pacer.missed) == (1000, 0)
    assert pacer.summary()["late_ms"] == {"p50": 3.0, "p99": 3.0, "max": 3.0}


@pytest.mark.parametrize(("took_s", "missed", "next_s"), [(0.0199, 0, 0.02), (0.021, 1, 0.04), (0.079, 3, 0.08)])
def test_misses_are_counted_and_the_grid_is_kept(took_s, missed, next_s):
    pacer = Pacer(50, 0.0)
    assert tick(pacer, 0.0, took_s) == missed
    assert pacer.missed == missed
    assert pacer.due_s == pytest.approx(next_s)


def test_quantiles():
    assert quantiles_ms([]) == {"p50": 0.0, "p99": 0.0, "max": 0.0}
    assert quantiles_ms([i / 1000 for i in range(101)]) == {"p50": 50.0, "p99": 99.0, "max": 100.0}
