"""Encoders: no loss in any number of turns, the range's end, speed, the rotor's turn, disagreement, the calf's rod."""

import math
import os
import random
import shutil
import subprocess
import sys
from array import array

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared.joint import encoder
from shared.record import pack
from tests import ROOT
from tests.float_twin import joint_motion as twin

from .plant import made

JOINT_TURN = 22 * 16384
STEP = st.integers(-8191, 8191)


@pytest.fixture
def joint():
    return make()


def make(**setup):
    blocks = made(**setup)
    encoder.encoder_reset(blocks.loop, blocks.settings, blocks.state)
    return blocks


def turn_to(blocks, count):
    blocks.loop.rotor = count & 16383
    return encoder.encoder_step(blocks.loop, blocks.settings, blocks.state)


def absolute(blocks):
    return blocks.state.turns * 16384 + blocks.state.fraction


@given(st.integers(-(1 << 29), 1 << 29))
def test_wrap_count(difference):
    assert encoder.wrap_count(difference) == (difference + 8192) % 16384 - 8192
    assert -8192 <= encoder.wrap_count(difference) <= 8191
    assert abs(encoder.wrap_count(difference)) == abs(twin.wrap(difference, 16384))


@given(st.lists(STEP, max_size=200), st.integers(-(1 << 29), 1 << 29))
def test_no_count_is_lost_in_any_number_of_turns(steps, turns):
    blocks = make()
    blocks.state.turns = turns
    total = turns * 16384
    for step in steps:
        total += step
        turn_to(blocks, total)
    assert absolute(blocks) == total


@given(st.integers(-32766, 32766), st.integers(0, 16383), st.integers(0, 16383), st.sampled_from((-1, 1)))
def test_position_is_exact_within_its_range(turns, fraction, zero, sign):
    assert encoder.position_of(turns, fraction, zero, sign) == sign * (turns * 16384 + fraction - zero)


@pytest.mark.parametrize("sign", [1, -1])
def test_at_the_end_of_its_range_the_position_stays_and_says_so(sign):
    blocks = make(sign=sign)
    blocks.state.turns = 32766
    total = 32766 * 16384
    seen = []
    for _ in range(10):
        total += 8000
        seen.append(turn_to(blocks, total) * sign)
    assert seen == sorted(seen)
    assert seen[-1] == (1 << 29) - 1
    assert blocks.state.range_exceeded == 1
    assert absolute(blocks) == total
    blocks.state.turns = (1 << 30) - 2
    for _ in range(5):
        total += 8000
        turn_to(blocks, total)
    assert blocks.state.turns == (1 << 30) - 2


def checked_turns(folder):
    """Run the encoder of the shared/ in ``folder`` over all turn counts, in a process of its own."""
    command = [sys.executable, "-m", "tests.shared.joint.checked_turns"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)


def test_no_turn_count_leaves_the_integers_or_gives_another_position():
    run = checked_turns(ROOT)
    assert run.returncode == 0, run.stderr[-1000:]
    assert int(run.stdout.split()[0]) > 65536


SUM = "return ((turns << 14) + fraction - zero) * sign"
STOP = "turns = saturate(state.turns + (fraction >> 14), -_TURNS_MOST, _TURNS_MOST)"
PLANTED = [
    ("a branch", SUM, "if turns == 12345:\n        turns = turns << 20 >> 20\n    " + SUM),
    ("a comparison", SUM, "return ((turns << 14) + ((turns == 31999) << 30) + fraction - zero) * sign"),
    ("no literal", SUM, "return ((turns << 14) + fraction - zero) * sign + (turns * turns * 2 >> 31)"),
    ("a wrong value", SUM, "return ((turns << 14) + fraction - zero + (turns == -20011)) * sign"),
    ("a far count", STOP, STOP + "\n    if turns == 23456789:\n        turns = turns + (1 << 30) - (1 << 30)"),
    ("a far sum", STOP, STOP + "\n    if turns == 3 * 1000003 + 5:\n        turns = turns + (1 << 30)"),
    ("the end", "_TURNS_MOST = const(0x3FFFFFFE)", "_TURNS_MOST = const(0x40000000)"),
    ("homing", "(wanted + 8192) >> 14", "(wanted + 8192 + (wanted >> 14 == 777) * 9999) >> 14"),
]


@pytest.mark.parametrize("row", PLANTED, ids=[row[0] for row in PLANTED])
def test_a_mistake_for_one_turn_count_is_found(tmp_path, row):
    _, right, wrong = row
    shutil.copytree(ROOT / "shared", tmp_path / "shared", ignore=shutil.ignore_patterns("__pycache__"))
    file = tmp_path / "shared/joint/encoder.py"
    assert file.read_text().count(right) == 1
    file.write_text(file.read_text().replace(right, wrong))
    run = checked_turns(tmp_path)
    assert run.returncode != 0
    assert "Overflow" in run.stderr or "instead of" in run.stderr or "choosing" in run.stderr


@pytest.mark.parametrize("rate", [-700.4, -3.3, 0.0, 0.26, 55.5, 780.1])
def test_tracking_loop_has_no_error_at_constant_speed(joint, rate):
    for i in range(400):
        turn_to(joint, int(i * rate + 0.5))
    mean = 0.0
    for i in range(400, 800):
        turn_to(joint, int(i * rate + 0.5))
        assert abs(joint.state.rate / 256 - rate) < 1.0
        mean += joint.state.rate / 256 / 400
    assert abs(mean - rate) < 0.01


@given(st.lists(st.integers(-8192, 8191), min_size=1, max_size=100))
def test_tracking_loop_stays_in_range_whatever_moves(moves):
    blocks = make()
    for moved in moves:
        assert abs(encoder.track_rate(blocks.settings, blocks.state, moved)) <= (1 << 19) - 1


@given(st.integers(-(1 << 27), 1 << 27), st.integers(0, 16383), st.integers(0, 16383), st.integers(-8191, 8191))
def test_choose_turn_finds_the_position_within_half_a_rotor_turn(true, zero, noise_at, error):
    blocks = make()
    blocks.settings.zero = zero
    blocks.state.fraction = (true + zero) & 16383
    left = encoder.choose_turn(blocks.settings, blocks.state, true + error)
    assert blocks.state.position == true
    assert left == error


@given(st.integers(0, 16383), st.integers(0, 16383), st.sampled_from((-1, 1)))
def test_joint_count(raw, zero, sign):
    blocks = make()
    blocks.settings.joint_encoder_zero, blocks.settings.joint_encoder_sign = zero, sign
    expected = encoder.wrap_count(raw - zero) * sign * 22
    assert encoder.joint_count(blocks.settings, raw) == expected


def read_joint(blocks, position_rc):
    blocks.io.joint_raw = math.floor(position_rc / 22) & 16383
    blocks.io.joint_valid = 1


@given(st.integers(-150000, 150000))
def test_home_by_the_joint_encoder(position):
    blocks = make()
    blocks.state.fraction = position & 16383
    read_joint(blocks, position)
    assert encoder.home_by_encoder(blocks.settings, blocks.state, blocks.io) == 1
    assert blocks.state.position == position


def test_homing_is_refused_while_ambiguous(joint):
    joint.state.fraction = 8000
    assert encoder.home_at(joint.settings, joint.state, 8000 + 16384 * 3 + 4097) == 0
    assert joint.state.homed == 0
    assert encoder.home_at(joint.settings, joint.state, 8000 + 16384 * 3 + 4096) == 1
    assert joint.state.position == 8000 + 16384 * 3
    assert encoder.home_by_encoder(joint.settings, joint.state, joint.io) == 0


@pytest.mark.parametrize("joint_turns", [-3, 0, 5])
def test_disagreement_is_seen_below_half_a_rotor_turn(joint, joint_turns):
    """8.18 deg of a 22:1 joint are 8192 rc; the threshold lies below it."""
    assert joint.settings.disagree < 8192
    position = 20000
    joint.state.homed = 1
    joint.state.position = position + joint_turns * JOINT_TURN
    for off, expected in ((0, 0), (5900, 0), (6100, 1), (-6100, 1), (16384, 1), (-16384, 1)):
        joint.state.disagree_ticks = 0
        read_joint(joint, position + off)
        assert encoder.watch_encoders(joint.settings, joint.state, joint.io) == expected, off
        assert abs(joint.state.joint_error - off) <= 22


def test_a_joint_encoder_that_is_missing_or_invalid_is_not_compared(joint):
    joint.state.homed = 1
    read_joint(joint, 100000)
    assert encoder.watch_encoders(joint.settings, joint.state, joint.io) == 1
    joint.io.joint_valid = 0
    assert encoder.watch_encoders(joint.settings, joint.state, joint.io) == 0
    joint.io.joint_valid, joint.settings.has_joint_encoder = 1, 0
    assert encoder.watch_encoders(joint.settings, joint.state, joint.io) == 0


def test_long_rotation_back_and_forth_ends_where_it_began(joint):
    rng = random.Random(5)
    total = 0
    for _ in range(3000):
        total += rng.randint(-4000, 8000)
        turn_to(joint, total)
    while total:
        total -= max(-8000, min(8000, total))
        turn_to(joint, total)
    assert joint.state.position == 0


def test_every_number_fits_a_boards_word(joint):
    for block in (joint.loop, joint.settings, joint.state, joint.io):
        assert list(array("i", pack(block))) == pack(block)
