"""Motor data become integers: gains, scales, refusals with one line, and the words of every fault."""

import math

import pytest

from host.robot.joint_faults import WORDS, fault_name, fault_sentence
from host.robot.joint_gains import joint_blocks
from host.robot.joint_units import AXIS_MOST_VU, WORD, Board, JointSetup, current_gains, ripple_A, trip_A
from host.util.errors import UserError
from shared.joint import faults
from tests import ROOT

from .plant import BLDC, changed, made


def test_gains_are_those_of_the_bandwidth():
    kp, ki = current_gains(BLDC)
    w = 2 * math.pi * BLDC.drive.current_bandwidth_hz
    assert (kp, ki) == (pytest.approx(0.6e-3 * w), pytest.approx(1.2 * w))
    blocks = made()
    scale = blocks.units.ampere_per_cu / blocks.units.volt_per_vu * 8192
    assert blocks.loop.kp == pytest.approx(kp * scale, abs=0.5)
    assert blocks.loop.ki == pytest.approx(ki / 10000 * scale, abs=0.5)


@pytest.mark.parametrize("limit_A", [0.5, 2.0, 4.0])
@pytest.mark.parametrize("bandwidth", [100, 300, 500])
@pytest.mark.parametrize("henry", [0.3e-3, 0.6e-3, 2e-3])
def test_the_current_step_cannot_overflow_with_what_is_accepted(limit_A, bandwidth, henry):
    bldc = changed(
        drive={"current_limit_A": limit_A, "current_bandwidth_hz": bandwidth, "pwm_hz": 60000},
        motor={"inductance_H": henry},
    )
    blocks = made(bldc)
    loop, units = blocks.loop, blocks.units
    error = (trip_A(bldc, Board()) + limit_A) / units.ampere_per_cu
    longest = Board().adc_volt * Board().bus_divider / math.sqrt(3) / units.volt_per_vu
    total = (loop.kp + loop.ki) * error + 2 * longest * 8192
    assert total < WORD
    assert total / 8192 + longest < AXIS_MOST_VU
    assert loop.ki > 8


@pytest.mark.parametrize(
    ("tables", "word"),
    [
        ({"drive": {"current_bandwidth_hz": 501.0}}, "current_bandwidth_hz 501: at most 500"),
        ({"drive": {"velocity_bandwidth_hz": 51.0}}, "velocity_bandwidth_hz 51: at most 50"),
        ({"drive": {"position_bandwidth_hz": 30.0}}, "position_bandwidth_hz 30: at most half"),
        ({"motor": {"inductance_H": 0.1e-3}}, "ripple of 3 A exceeds current_limit_A 2"),
        ({"drive": {"current_limit_A": 6.0}}, "current_limit_A 6: at most 60 %"),
        ({"gear": {"ratio": 80.0}}, "gear.ratio 80"),
        ({"drive": {"over_voltage_V": 60.0}}, "over_voltage_V 60: the board reads up to 42.9 V"),
        ({"drive": {"pwm_hz": 8000}}, "pwm_hz 8000: allowed 12000 .. 168000"),
        ({"drive": {"speed_limit_rad_s": 40.0}}, "speed_limit_rad_s: gives"),
        ({"motor": {"inductance_H": 20e-3}}, "kp = L w does not fit"),
    ],
)
def test_what_cannot_be_served_is_refused_in_one_line(tables, word):
    with pytest.raises(UserError) as caught:
        made(changed(**tables))
    assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_limits_the_wrong_way_round_are_refused():
    with pytest.raises(UserError, match="the lower one must be below"):
        joint_blocks(BLDC, JointSetup(1.0, -1.0))


def test_ripple():
    assert ripple_A(BLDC) == pytest.approx(24 / (4 * 0.6e-3 * 20000))


def test_every_fault_has_its_words():
    codes = {getattr(faults, n) for n in dir(faults) if n.startswith("FAULT_") and n != "FAULT_COAST_FROM"}
    assert codes == set(WORDS)
    units = made().units
    for code in codes:
        sentence = fault_sentence(code, 1234, units)
        assert sentence.startswith(fault_name(code))
        assert "\n" not in sentence
        assert ";" in sentence
        assert "{" not in sentence + fault_sentence(code, 1234)


def test_sentences_name_cause_and_value():
    units = made().units
    assert "17 V" in fault_sentence(faults.FAULT_UNDER_VOLTAGE, round(17 / units.volt_per_vu), units)
    assert "4352 vu" in fault_sentence(faults.FAULT_UNDER_VOLTAGE, 4352)
    assert "111 degrees C" in fault_sentence(faults.FAULT_WINDING_HOT, 1776)
    assert "101 ms" in fault_sentence(faults.FAULT_WATCHDOG, 101)
    assert "unknown fault 250" in fault_sentence(250, 3)
    assert fault_name(250) == "unknown fault 250"


def test_the_docs_list_every_fault():
    text = (ROOT / "docs/joint.md").read_text()
    for code, words in WORDS.items():
        assert code == 0 or f"| {code} | {words.name} | {words.sentence.replace('{}', '*value*')} |" in text
