"""shared/gait/swing.py against the paper's formulas: sample instants, cycloid, slopes, heights."""

from itertools import pairwise

import pytest
from hypothesis import given, settings

from shared.gait.swing import cycloid_q15, lift_q15, swing_phase_q16
from tests.float_twin import swing as twin

from .bars import WORD, integers

P_T, P_N = 0.66, 0.33
P_T_Q16, P_N_Q16 = 66 * 65536 // 100, (33 * 65536 + 99) // 100


def test_sample_instants_are_the_papers():
    """N = 25, T = 0.5 s: 8 samples over 0 .. 0.33 s, 17 more to 0.5 s (section 2.5.3)."""
    linspace = [0.33 * i / 7 for i in range(8)] + [0.33 + 0.17 * i / 17 for i in range(1, 18)]
    assert [0.5 * phase for phase in twin.instants(25, P_T, P_N)] == pytest.approx(linspace)
    got = [0.5 * swing_phase_q16(i, 25, P_T_Q16, P_N_Q16) / 65536 for i in range(25)]
    assert got == pytest.approx(linspace, abs=0.5 * 2 / 65536)
    assert (got[0], got[24]) == (0.0, 0.5)


@pytest.mark.parametrize(("p_t", "p_n"), [(65536, 65536), (65536, P_N_Q16), (P_T_Q16, 65536)])
def test_either_of_the_two_at_one_gives_even_samples(p_t, p_n):
    got = [swing_phase_q16(i, 25, p_t, p_n) for i in range(25)]
    assert got == pytest.approx([65536 * i / 24 for i in range(25)], abs=1)


@settings(max_examples=800)
@given(integers(1, 16383), integers(0, 65536), integers(0, 65536), integers(0, 1 << 20))
def test_any_re_timing_is_the_twins_and_rises_from_0_to_1(samples, p_t, p_n, at):
    sample = at % samples
    exact = twin.instants(samples, p_t / 65536, p_n / 65536) if samples > 1 else [0.0]
    assert abs(swing_phase_q16(sample, samples, p_t, p_n) - 65536 * exact[sample]) <= 1
    if sample + 1 < samples:
        assert swing_phase_q16(sample, samples, p_t, p_n) <= swing_phase_q16(sample + 1, samples, p_t, p_n)


@settings(max_examples=200)
@given(WORD, integers(-5, 16383))
def test_samples_outside_are_the_first_or_the_last(sample, samples):
    phase = swing_phase_q16(sample, samples, P_T_Q16, P_N_Q16)
    assert 0 <= phase <= 65536
    if sample <= 0:
        assert phase == 0
    elif sample >= samples > 1:
        assert phase == 65536


def test_cycloid_and_lift_are_within_one_lsb_at_every_phase():
    assert max(abs(cycloid_q15(phase) - 32768 * twin.advance(phase / 65536)) for phase in range(65537)) <= 1.0
    assert max(abs(lift_q15(phase) - 32768 * twin.lift(phase / 65536)) for phase in range(65537)) <= 1.0


def test_ends_are_exact_and_have_no_slope():
    assert (cycloid_q15(0), cycloid_q15(65536)) == (0, 32768)
    assert (lift_q15(0), lift_q15(65536)) == (0, 0)
    for near_end in (0, 65536 - 256):
        assert abs(cycloid_q15(near_end + 256) - cycloid_q15(near_end)) <= 1
        assert abs(lift_q15(near_end + 256) - lift_q15(near_end)) <= 6


def test_the_way_forward_never_goes_back_by_more_than_one_lsb():
    ways = [cycloid_q15(phase) for phase in range(65537)]
    assert all(b >= a - 1 for a, b in pairwise(ways))
