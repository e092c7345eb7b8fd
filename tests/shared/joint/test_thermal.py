"""Temperatures: curves, the sensor in the chip, the two-node model, I2t."""

import math
from array import array

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from host.robot.joint_heat import COPPER_PER_K, SLOW_HZ
from host.robot.joint_units import Board
from host.robot.thermistor import part_of
from host.util.errors import UserError
from shared.joint import thermal
from tests.float_twin import joint_motion as twin

from .plant import BLDC, changed, made


def accepted(board, **thermal):
    """Return the blocks of a joint with that part, None if it is refused."""
    try:
        return made(changed(thermal=thermal), board)
    except UserError:
        return None


@settings(max_examples=40)
@given(
    st.sampled_from(("ntc", "ptc")), st.floats(1.0, 6.0), st.floats(100.0, 10000.0), st.floats(2.0, 5.0),
    st.floats(30.0, 200.0),
)  # fmt: skip
@example("ntc", math.log10(10000), 3435.0, 3.0, 110.0)
@example("ntc", math.log10(4700), 3435.0, 3.0, 110.0)
@example("ntc", math.log10(10000), 3950.0, 4.0, 200.0)
@example("ptc", math.log10(1000), 100.0, 3.0, 110.0)
def test_every_part_the_file_can_name_is_read_within_a_degree_or_refused(kind, decades, beta, pull_up, cutoff):
    """From its resistance at the true temperature, rounded by the ADC; the formula is the twin's, not the curve's."""
    ohm25 = 10**decades
    board = Board(thermistor_pull_up_ohm=10**pull_up)
    limits = {"winding_cutoff_C": cutoff, "winding_derate_C": 29}
    blocks = accepted(board, thermistor=kind, thermistor_25C_ohm=ohm25, thermistor_beta_K=beta, **limits)
    for tenths in range(-200, 10 * max(150, int(cutoff)), 7):
        celsius = tenths / 10
        ohm = twin.silicon_ohm(celsius, ohm25) if kind == "ptc" else twin.ntc_ohm(celsius, ohm25, beta)
        raw = round(4096 * ohm / (ohm + board.thermistor_pull_up_ohm))
        if blocks is not None:
            assert blocks.settings.short_raw < raw < blocks.settings.open_raw
            assert abs(thermal.thermistor_t16(blocks.curve, raw) / 16 - celsius) <= 1.1  # checked every 0.2 K


@pytest.mark.parametrize("ohm", [470, 1000, 4700, 10000, 22000])
def test_the_usual_parts_are_taken(ohm):
    assert accepted(Board(), thermistor_25C_ohm=ohm)
    assert accepted(Board(thermistor_pull_up_ohm=ohm), thermistor_25C_ohm=4700) or ohm > 10000


def test_a_part_the_board_cannot_read_is_refused_with_what_it_can():
    with pytest.raises(UserError) as caught:
        made(changed(thermal={"thermistor_25C_ohm": 100000}))
    assert str(caught.value) == (
        "actuator.thermal.thermistor_25C_ohm 100000: use 220 .. 22000 ohm, "
        "which the board with its pull-up of 1000 ohm reads within a degree"
    )


def test_the_ntc_is_the_formula():
    part = part_of(BLDC, Board())
    assert part.celsius(1000) == pytest.approx(25.0)
    assert part.celsius(200) == pytest.approx(twin.ntc(200, 1000, 3435))


COUNTS = st.lists(st.integers(0, 4095), min_size=32, max_size=32).map(sorted)
TEMPERATURES = st.lists(st.integers(-(1 << 16), 1 << 16), min_size=32, max_size=32)


@given(st.integers(-100, 5000), COUNTS, TEMPERATURES)
def test_a_curve_is_straight_between_its_points(raw, counts, temperatures):
    value = thermal.thermistor_t16(array("i", counts + temperatures), raw)
    last = max((i for i in range(32) if counts[i] <= raw), default=0)
    points = list(zip(counts, temperatures, strict=True))
    expected = temperatures[last] if last == 31 or raw <= counts[last] else between(raw, points[last], points[last + 1])
    assert abs(value - expected) <= 1


def between(raw, low, high):
    return low[1] + (high[1] - low[1]) * (raw - low[0]) / (high[0] - low[0])


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
    blocks = made()
    t = BLDC.thermal
    nodes = twin.TwoNodes(t.winding_J_K, t.housing_J_K, t.winding_to_housing_K_W, t.housing_to_air_K_W)
    square = round(ampere / blocks.units.ampere_per_cu) ** 2 >> 8
    thermal.model_reset(blocks.state, 25 * 16)
    for _ in range(seconds * SLOW_HZ):
        value = thermal.model_step(blocks.settings, blocks.state, square)
        nodes.step(twin.copper_W(BLDC.motor.resistance_ohm, ampere, 25 + nodes.winding), 1 / SLOW_HZ)
    assert value / 16 == pytest.approx(25 + nodes.winding, abs=1.0)


def test_hot_copper_heats_more():
    """A lasting current that would bring copper of 25 degrees C to 70 brings real copper to 79.7."""
    t, blocks = BLDC.thermal, made()
    cold_K = 45.0
    ampere = math.sqrt(cold_K / (t.winding_to_housing_K_W + t.housing_to_air_K_W) / 1.5 / BLDC.motor.resistance_ohm)
    square = round(ampere / blocks.units.ampere_per_cu) ** 2 >> 8
    thermal.model_reset(blocks.state, 25 * 16)
    for _ in range(6000 * SLOW_HZ):
        value = thermal.model_step(blocks.settings, blocks.state, square)
    assert value / 16 == pytest.approx(25 + cold_K / (1 - COPPER_PER_K * cold_K), abs=1.0)


@given(st.integers(-(1 << 29), 1 << 29))
def test_copper_share(t16):
    share = thermal.copper_share(t16)
    within = max(-37.5, min(279.375, t16 / 16))
    assert abs(share / 16384 - COPPER_PER_K * (within - 25)) < 1e-4


@given(st.lists(st.integers(0, (1 << 19) - 1), min_size=1, max_size=60))
def test_the_model_stays_in_range(squares):
    blocks = made()
    for square in squares * 20:
        value = thermal.model_step(blocks.settings, blocks.state, square)
        assert 0 <= value <= 256 * 16


def test_i2t_leaves_the_lasting_current_after_the_peak_time():
    blocks = made(continuous_A=1.2, peak_s=8.0)
    square = round(2.0 / blocks.units.ampere_per_cu) ** 2 >> 8
    shares = [thermal.i2t_step(blocks.settings, blocks.state, square) for _ in range(10 * SLOW_HZ)]
    assert shares[: 4 * SLOW_HZ - 2] == [0x8000] * (4 * SLOW_HZ - 2)
    assert shares == sorted(shares, reverse=True)
    assert shares[8 * SLOW_HZ] == 0
    rest = [thermal.i2t_step(blocks.settings, blocks.state, 0) for _ in range(20 * SLOW_HZ)]
    assert rest[-1] == 0x8000
    assert math.isclose(rest.index(0x8000) / SLOW_HZ, 4.0 * (4.0 - 1.44) / 1.44, rel_tol=0.1)
