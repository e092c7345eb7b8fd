"""Only exactly a message is a message."""

import json

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from host.control.messages import KEYS, LONGEST, BadMessage, Drive, check, parse

from .rig import AHEAD, RESET, STAND, STOP

GOOD = [
    AHEAD,
    {**AHEAD, "t_ms": 1.7e12},
    STAND,
    STOP,
    RESET,
    {"type": "take"},
    {"type": "release"},
    {"type": "gait", "gait": "crawl"},
    {"type": "balance", "on": False},
    {"type": "ping", "t_ms": 12.5},
]
BAD = [
    "",
    "{",
    "null",
    "[]",
    "5",
    '"stop"',
    "{}",
    '{"type": "fly"}',
    '{"type": ["stop"]}',
    '{"type": {"type": "stop"}}',
    '{"type": "stop", "extra": 1}',
    '{"type": "posture"}',
    '{"type": "posture", "posture": "limp"}',
    '{"type": "posture", "posture": ["stand"]}',
    '{"type": "gait", "gait": 1}',
    '{"type": "balance", "on": 1}',
    '{"type": "ping", "t_ms": NaN}',
    '{"type": "ping", "t_ms": true}',
    '{"type": "ping", "t_ms": 1e999}',
    json.dumps({**AHEAD, "vx_m_s": "0.1"}),
    json.dumps({**AHEAD, "vx_m_s": 11}),
    json.dumps({**AHEAD, "pose": [0.0] * 5}),
    json.dumps({**AHEAD, "pose": [0, 0, 0, 0, 0, None]}),
    json.dumps({**AHEAD, "pose": 0}),
    '{"type": "drive", "vx_m_s": Infinity, "vy_m_s": 0, "wz_rad_s": 0, "pose": [0,0,0,0,0,0]}',
    json.dumps({**AHEAD, "vx_m_s": 10**400})[:LONGEST],
    json.dumps(STOP) + " " * LONGEST,
    "[" * 500,
    b"\xff\xfe",
]


@pytest.mark.parametrize("message", GOOD, ids=lambda message: message["type"])
def test_good_messages_pass(message):
    assert parse(json.dumps(message)) == message


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_bad_messages_are_refused(text):
    with pytest.raises(BadMessage):
        parse(text)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(st.text(max_size=8), inner, max_size=5),
    max_leaves=12,
)
NEARLY = st.fixed_dictionaries(
    {"type": st.sampled_from(sorted(KEYS))},
    optional=dict.fromkeys(("vx_m_s", "vy_m_s", "wz_rad_s", "pose", "posture", "gait", "on", "t_ms"), JSON),
)


@settings(max_examples=300)
@given(JSON | NEARLY)
@example({"type": "stop", "t_ms": float("nan")})
def test_anything_is_a_message_or_refused(value):
    try:
        message = check(value)
    except BadMessage:
        return
    allowed = set(KEYS[message["type"]]) | {"type", "t_ms"}
    assert set(message) <= allowed
    if message["type"] == "drive":
        assert all(abs(number) <= 10 for number in (Drive.of(message).vx_m_s, *Drive.of(message).pose))


@settings(max_examples=300)
@given(st.binary(max_size=LONGEST + 5) | st.text(max_size=LONGEST))
def test_any_bytes_are_survived(data):
    try:
        assert parse(data)["type"] in KEYS
    except BadMessage:
        return
