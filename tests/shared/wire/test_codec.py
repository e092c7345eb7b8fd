"""The integer codec against cantools, which reads the same DBC by its own parser; both ways, every kind of frame."""

import random

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host.protocol import dbc, frames
from host.protocol.generate_docs import expanded_dbc

MESSAGES = dbc.load()
WITH_FIELDS = [m for m in MESSAGES if m.signals]
LIBRARY = cantools.database.load_string(expanded_dbc(MESSAGES), "dbc")
CORE_LOW, CORE_HIGH = -(1 << 30), (1 << 30) - 1
RANDOM_PER_KIND = 100_000  # of the long run: pytest -m slow tests/shared/wire


def allowed(signal):
    values = st.integers(signal.low, signal.high)
    return values if signal.special is None else values | st.just(signal.special)


def saturated(signal, raw):
    return raw if raw == signal.special else max(signal.low, min(signal.high, raw))


def library_bytes(identifier, raws):
    signals = LIBRARY.get_message_by_frame_id(identifier).signals
    data = {s.name: raw for s, raw in zip(sorted(signals, key=lambda s: s.start), raws, strict=True)}
    return LIBRARY.encode_message(identifier, data, scaling=False, strict=False)


def library_fields(identifier, data, **how):
    signals = sorted(LIBRARY.get_message_by_frame_id(identifier).signals, key=lambda s: s.start)
    decoded = LIBRARY.decode_message(identifier, data, **how)
    return [decoded[s.name] for s in signals]


def check_encode(message, identifier, raws):
    """Whatever the values: ours equals the library's bytes of the limited values, and counts the limited ones."""
    limited = [saturated(s, raw) for s, raw in zip(message.signals, raws, strict=True)]
    data, clipped = frames.encode(identifier, raws)
    assert data == library_bytes(identifier, limited)
    assert clipped == sum(a != b for a, b in zip(raws, limited, strict=True))


def check_decode(message, identifier, data):
    """Whatever the bytes: ours equals the library's raw values and what they mean, and counts those not allowed."""
    raws, outside = frames.decode(identifier, data)
    assert raws == library_fields(identifier, data, scaling=False, decode_choices=False)
    assert outside == sum(saturated(s, raw) != raw for s, raw in zip(message.signals, raws, strict=True))
    described = frames.describe(identifier, data).values()
    for signal, ours, theirs in zip(message.signals, described, library_fields(identifier, data), strict=True):
        assert signal.is_flags or ours == theirs  # the library has no words for bits


@pytest.mark.parametrize("message", WITH_FIELDS, ids=lambda m: m.name)
def test_codec_equals_cantools(message):
    @settings(max_examples=60)
    @given(st.data())
    def run(data):
        identifier = data.draw(st.sampled_from(message.identifiers))
        check_encode(message, identifier, [data.draw(allowed(s)) for s in message.signals])
        check_encode(message, identifier, [data.draw(st.integers(CORE_LOW, CORE_HIGH)) for _ in message.signals])
        check_decode(message, identifier, data.draw(st.binary(min_size=message.length, max_size=message.length)))

    run()


@pytest.mark.parametrize("message", WITH_FIELDS, ids=lambda m: m.name)
def test_codec_edges(message):
    """Each field alone at each of its edges and beyond, the others zero (or their least)."""
    rest = [max(0, s.low) for s in message.signals]
    for place, s in enumerate(message.signals):
        edges = {0, 1, -1, s.low, s.high, s.low - 1, s.high + 1, s.bit_low, s.bit_high, -32768, CORE_LOW, CORE_HIGH}
        for raw in sorted(edge for edge in edges if CORE_LOW <= edge <= CORE_HIGH):
            check_encode(message, message.identifiers[0], [*rest[:place], raw, *rest[place + 1 :]])
    for byte in (0x00, 0x01, 0x7F, 0x80, 0xFF):
        check_decode(message, message.identifiers[0], bytes([byte] * message.length))


@pytest.mark.slow
@pytest.mark.parametrize("message", WITH_FIELDS, ids=lambda m: m.name)
def test_codec_equals_cantools_at_length(message):
    draw = random.Random(message.identifier)
    for _ in range(RANDOM_PER_KIND):
        identifier = draw.choice(message.identifiers)
        if draw.random() < 0.5:
            raws = [draw.randint(s.low, s.high) for s in message.signals]
        else:
            raws = [draw.choice((draw.randint(CORE_LOW, CORE_HIGH), s.bit_low, s.high)) for s in message.signals]
        check_encode(message, identifier, raws)
        check_decode(message, identifier, draw.randbytes(message.length))


@pytest.mark.parametrize("message", WITH_FIELDS, ids=lambda m: m.name)
def test_zero_is_exact_and_round_trips(message):
    zeros = [0 if s.low <= 0 else s.low for s in message.signals]
    data, clipped = frames.encode(message.identifiers[0], zeros)
    assert clipped == 0
    assert frames.decode(message.identifiers[0], data) == (zeros, 0)
    assert all(s.offset == 0 for s in message.signals)  # so raw 0 is 0 in the unit, too


@given(st.integers(CORE_LOW, CORE_HIGH))
def test_nothing_wraps_into_no_change(raw):
    data, clipped = frames.encode(0x100, [raw, -raw - 1, 0, -32768])
    values, _ = frames.decode(0x100, data)
    assert values == [saturated(MESSAGES[2].signals[0], v) for v in (raw, -raw - 1, 0, -32768)]
    assert (values[0] == -32768) == (raw == -32768)
    assert (clipped == 0) == (values[:2] == [raw, -raw - 1])


def test_short_and_unknown_frames_are_none():
    assert frames.decode(0x201, bytes(5)) is None
    assert frames.decode(0x7FF, bytes(8)) is None
    assert frames.describe(0x20F, bytes(8)) is None
    assert frames.decode(0x000, b"") == ([], 0)


def test_limits_are_described_by_their_words():
    data, _ = frames.encode(0x281, [25 * 16, -4096, 24 * 16, 1 | 64, 3, 0])
    assert frames.describe(0x281, data) == {
        "winding_temperature": 25.0, "mcu_temperature": "not_available", "bus_voltage": 24.0,
        "limits": "current winding_temperature", "lost_sync": 3.0, "overruns": 0.0,
    }  # fmt: skip
