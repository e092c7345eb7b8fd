"""Cogging: the waves beside floats, the current limit, and that they act only while the joint drives."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared.joint.cogging import cogging_step, put_wave, set_waves, switch_waves
from shared.joint.commutation import fill_sine
from shared.joint.drive_state import drive_arm, drive_disarm, drive_quick_stop
from shared.joint.layout import WAVES, CurrentLoop
from shared.wire import names as w

from .plant import Plant

WAVE = st.tuples(st.integers(0, 511), st.integers(0, 6000), st.integers(-32768, 65535))


def looped(waves, most=12288):
    loop = CurrentLoop()
    fill_sine(loop)
    loop.current_most = most
    for at, wave in enumerate(waves):
        put_wave(loop, at, *wave)
    switch_waves(loop, 1)
    return loop


@given(st.lists(WAVE, min_size=WAVES, max_size=WAVES), st.integers(0, 16383), st.integers(-8000, 8000))
def test_waves_beside_floats(waves, rotor, wanted):
    loop = looped(waves)
    loop.reference_q = wanted
    exact = sum(q4 / 16 * math.sin((order * rotor / 16384 + brad / 65536) * math.tau) for order, q4, brad in waves)
    angle = 2 * math.tau / 1024  # two places of the sine table: reading and phase are rounded to one
    assert abs(cogging_step(loop, rotor) - exact) <= 1.5 + angle * sum(q4 / 16 for _, q4, _ in waves)


@given(st.lists(WAVE, min_size=WAVES, max_size=WAVES), st.integers(0, 16383), st.integers(-1000, 1000))
def test_wanted_current_and_waves_together_stay_within_the_limit(waves, rotor, wanted):
    loop = looped(waves, most=1000)
    loop.reference_q = wanted
    assert abs(wanted + cogging_step(loop, rotor)) <= 1000


def test_waves_that_are_off_leave_nothing_behind():
    loop = looped([(42, 900, 16384)] * WAVES)
    assert cogging_step(loop, 0) > 100
    assert switch_waves(loop, 0) == 0
    assert (loop.waves, loop.cogging_q) == (0, 0)


def test_the_stored_waves_are_handed_on():
    p = Plant()
    p.settings.cogging_order_1, p.settings.cogging_current_1, p.settings.cogging_phase_1 = 84, 1600, -16384
    assert set_waves(p.loop, p.settings) == WAVES
    assert (p.loop.wave_order[1], p.loop.wave_current[1], p.loop.wave_phase[1]) == (84, 1600, 768)


@pytest.mark.parametrize(("torque", "waves"), [("drive", WAVES), ("quick stop", 0), ("off", 0), ("stopped", 0)])
def test_they_act_only_while_the_joint_drives(torque, waves):
    p = Plant()
    p.settings.cogging_order_0, p.settings.cogging_current_0 = 42, 1600
    set_waves(p.loop, p.settings)
    p.state.homed = 1
    p.io.mode = w.MODE_CURRENT
    p.run(10)
    assert drive_arm(p.settings, p.state, p.io, w.MODE_OFF) == w.RESULT_OK
    p.run(10)
    assert p.loop.waves == WAVES
    if torque == "quick stop":
        p.speed = 200.0
        drive_quick_stop(p.state)
    elif torque == "off":
        drive_disarm(p.state)
    elif torque == "stopped":
        p.io.e_stop = 1
    p.run(2)
    assert p.loop.waves == waves
    assert waves or p.loop.cogging_q == 0
