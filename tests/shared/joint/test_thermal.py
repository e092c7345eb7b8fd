"""Temperatures: curves, the sensor in the chip, the two-node model, I2t."""

import math
from array import array

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.joint_gains import joint_blocks
from host.joint_heat import SLOW_HZ, thermistor_C
from host.joint_units import Board, JointSetup
from host.robot_file import load_robot
from shared.joint import thermal
from tests.float_twin import joint_motion as twin

BLDC = load_robot("parallel").actuator
PTC = BLDC.model_copy(update={"thermal": BLDC.thermal.model_copy(update={"thermistor": "ptc"})})


def make(bldc=BLDC, **setup):
    return joint_blocks(bldc, JointSetup(-1.0, 1.9, **setup))


@pytest.mark.parametrize("bldc", [BLDC, PTC])
@pytest.mark.parametrize("celsius", [-10, 0, 25, 60, 80, 100, 110, 130])
def test_thermistor_within_a_degree(bldc, celsius):
    ohms = [(raw, Board().thermistor_pull_up_ohm * raw / (4096 - raw)) for raw in range(100, 4000)]
    raw, ohm = min(ohms, key=lambda pair: abs(thermistor_C(bldc, pair[1]) - celsius))
    assert thermal.thermistor_t16(make(bldc).curve, raw) / 16 == pytest.approx(thermistor_C(bldc, ohm), abs=1.0)


def test_the_ntc_is_the_formula():
    assert thermistor_C(BLDC, 1000) == pytest.approx(25.0)
    assert thermistor_C(BLDC, 200) == pytest.approx(twin.ntc(200, 1000, 3435))


@given(st.integers(-100, 5000), st.lists(st.integers(-(1 << 20), 1 << 20), min_size=65, max_size=65))
def test_a_curve_is_interpolated_between_its_points(raw, points):
    value = thermal.thermistor_t16(array("i", points), raw)
    at = max(0, min(4095, raw))
    low, high = points[at // 64], points[at // 64 + 1]
    assert abs(value - (low + (high - low) * (at % 64) / 64)) <= 1


@given(st.integers(0, 4095), st.integers(0, 4095), st.integers(0, 4095))
def test_the_sensor_in_the_chip(raw, cal1, cal2):
    value = thermal.mcu_t16(raw, cal1, cal2)
    if cal1 == cal2:
        assert value == 32767
    else:
        assert abs(value / 16 - twin.mcu(raw, cal1, cal2)) <= 1 / 16


@given(st.integers(-(1 << 26), 1 << 26), st.integers(0, 16383), st.integers(13, 30))
def test_scaled(value, factor, shift):
    assert abs(thermal.scaled(value, factor, shift) - value * factor / 2**shift) <= 1


@pytest.mark.parametrize(("ampere", "seconds"), [(2.0, 10), (2.0, 600), (1.0, 1500), (3.0, 30)])
def test_the_model_follows_its_twin(ampere, seconds):
    blocks = make()
    t = BLDC.thermal
    nodes = twin.TwoNodes(t.winding_J_K, t.housing_J_K, t.winding_to_housing_K_W, t.housing_to_air_K_W)
    square = round(ampere / blocks.units.ampere_per_cu) ** 2 >> 8
    thermal.model_reset(blocks.state, 25 * 16)
    for _ in range(seconds * SLOW_HZ):
        value = thermal.model_step(blocks.cfg, blocks.state, square)
        nodes.step(1.5 * BLDC.motor.resistance_ohm * ampere**2, 1 / SLOW_HZ)
    assert value / 16 == pytest.approx(25 + nodes.winding, abs=1.0)


@given(st.lists(st.integers(0, (1 << 19) - 1), min_size=1, max_size=60))
def test_the_model_stays_in_range(squares):
    blocks = make()
    for square in squares * 20:
        value = thermal.model_step(blocks.cfg, blocks.state, square)
        assert 0 <= value <= 256 * 16


def test_i2t_leaves_the_lasting_current_after_the_peak_time():
    blocks = make(continuous_A=1.2, peak_s=8.0)
    square = round(2.0 / blocks.units.ampere_per_cu) ** 2 >> 8
    shares = [thermal.i2t_step(blocks.cfg, blocks.state, square) for _ in range(10 * SLOW_HZ)]
    assert shares[: 4 * SLOW_HZ - 2] == [0x8000] * (4 * SLOW_HZ - 2)
    assert shares == sorted(shares, reverse=True)
    assert shares[8 * SLOW_HZ] == 0
    rest = [thermal.i2t_step(blocks.cfg, blocks.state, 0) for _ in range(20 * SLOW_HZ)]
    assert rest[-1] == 0x8000
    assert math.isclose(rest.index(0x8000) / SLOW_HZ, 4.0 * (4.0 - 1.44) / 1.44, rel_tol=0.1)
