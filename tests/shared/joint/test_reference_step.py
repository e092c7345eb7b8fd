"""The current step against the readable form of the same arithmetic: equal to the bit, whatever it is given."""

import random
from copy import copy
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.joint import current
from shared.joint.commutation import fill_sine
from shared.joint.feed import feed_bus
from shared.joint.layout import SINE_SIZE, CurrentLoop, JointSettings
from shared.record import pack

from . import reference_step as reference

LOOP = CurrentLoop()
fill_sine(LOOP)
CONFIG = JointSettings()
SWING = (-2048, 2047)
RANGES = {  # what a step may find; limits of the parameters are those of parameters.toml
    "rotor": (0, 16383), "moved": (-700, 700), "anywhere": (0, 3), "invalid": (0, 9), "masked": (0, 7),
    "sampled": (0, 3), "a": SWING, "b": SWING, "c": SWING, "shrunk": (0, 11), "reference_d": (-12288, 12288),
    "reference_q": (-12288, 12288), "feed_d": (-23170, 23170), "feed_q": (-23170, 23170), "bus": (64, 23170),
    "offset_a": (-4000, 4000), "offset_b": (-4000, 4000), "offset_c": (-4000, 4000), "pole_pairs": (-50, 50),
    "electrical_offset": (-33000, 70000), "kp": (64, 16383), "ki": (8, 4095), "period": (500, 7000), "pulse": (0, 250),
    "window": (0, 250), "trip_square": (1, 150994944), "integral_d": (-1 << 28, 1 << 28),
    "integral_q": (-1 << 28, 1 << 28), "voltage_d": (-8000, 8000), "voltage_q": (-8000, 8000),
}  # fmt: skip


def copied(loop):
    """Return a block of its own, but for the sine table."""
    made = copy(loop)
    made.raw, made.duty, made.offset_q4 = list(loop.raw), list(loop.duty), list(loop.offset_q4)
    return made


def prepared(given):
    """Return a joint's block in the middle of its life, the rotor's reading and whether that failed its check."""
    loop = copied(LOOP)
    for name in RANGES.keys() & {name for name, _ in CurrentLoop.FIELDS}:
        setattr(loop, name, given[name])
    loop.half_period = loop.period * 8 + 8
    loop.span_max = (loop.period - 2 * max(loop.pulse, loop.window) - 1) * 16
    loop.electrical_gain = 4 * given["pole_pairs"]
    loop.masked = 0 if given["sampled"] else given["masked"]
    loop.raw[:] = (2048 + (given[phase] >> given["shrunk"]) for phase in "abc")
    current.set_offsets(loop, *(32768 + given[f"offset_{phase}"] for phase in "abc"))
    feed_bus(loop, CONFIG, given["bus"])
    moved = given["moved"] if given["anywhere"] else given["moved"] * 12
    return loop, given["rotor"] + moved & 16383, int(given["invalid"] == 0)


def step(module, loop, rotor, invalid):
    """Return (whether the bridge may stay on, what the block holds) after a step as the interrupt does it."""
    code = first = module.current_step(rotor, invalid, loop)
    if code:
        code = module.current_repair(code, rotor, invalid, loop)
    return first, (code == current.STEP_DONE, pack(loop)[:-SINE_SIZE])


def both(module, drawn):
    """Return the first code of the step, what it did and what the reference does."""
    loop, rotor, invalid = prepared(drawn)
    expected = copied(loop)
    on = reference.step(expected, rotor, invalid)
    return *step(module, loop, rotor, invalid), (on, pack(expected)[:-SINE_SIZE])


def draws(count, seed=1):
    noise = random.Random(seed)
    return [{name: noise.randint(low, high) for name, (low, high) in RANGES.items()} for _ in range(count)]


@settings(max_examples=600)
@given(st.fixed_dictionaries({name: st.integers(low, high) for name, (low, high) in RANGES.items()}))
def test_the_step_is_the_reference_to_the_bit(drawn):
    _, found, expected = both(current, drawn)
    assert found == expected


def test_every_way_through_the_step_is_the_references():
    codes = set()
    for drawn in draws(4000):
        code, found, expected = both(current, drawn)
        assert found == expected
        codes.add(code)
    assert codes == {current.STEP_DONE, current.STEP_INPUT, current.STEP_LIMIT, current.STEP_SHAPE, current.STEP_TRIP}


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("+ 8192) >> 14", "+ 8000) >> 14"),
        ("loop.integral_q + 4096", "loop.integral_q"),
        ("d = y >> 1", "d = y // 2 + (y & 1)"),
        ("& _JUMP_OUTSIDE | loop.masked | q:", "& _JUMP_OUTSIDE | loop.masked:"),
        ("if (v ^ error) >= 0:\n            loop.integral_q", "if (v ^ error) < 0:\n            loop.integral_q"),
        ("c = y - (s * q >> 22)", "c = y + (s * q >> 22)"),
        ("elif y < q:", "elif y > q:"),
        ("limit = round_sqrt(", "limit = isqrt("),
    ],
)
def test_a_mistake_is_found(right, wrong):
    text = Path(current.__file__).read_text()
    assert right in text
    planted = ModuleType("shared.joint.planted")
    planted.__package__ = "shared.joint"
    text = text.replace("import round_sqrt", "import isqrt, round_sqrt").replace(right, wrong)
    exec(compile(text, "planted", "exec"), planted.__dict__)
    results = [both(planted, drawn)[1:] for drawn in draws(1500, seed=2)]
    assert any(found != expected for found, expected in results)
