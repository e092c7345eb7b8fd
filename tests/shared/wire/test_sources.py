"""The sources of the protocol, joints.dbc and parameters.toml, their readers, and that all generated files follow."""

import math
from fractions import Fraction

import cantools
import pytest

from host.protocol import dbc, parameters
from host.protocol import generate as wire
from host.protocol import generate_codec as wire_codec
from host.protocol import generate_docs as wire_docs
from host.robot.file import load_robot
from host.robot.joint_gains import joint_blocks
from host.robot.joint_units import JointSetup
from shared.joint import faults
from shared.joint.layout import JointSettings, LoopSettings
from shared.joint.thermal import CURVE_POINTS, CURVE_SIZE
from shared.wire import access, names
from shared.wire import parameters as table

TEXT = dbc.SOURCE.read_text()
PARAMETERS_TEXT = parameters.SOURCE.read_text()


def number(dbc_text=TEXT, parameters_text=PARAMETERS_TEXT):
    return wire.protocol_hash(dbc.with_faults(dbc.parse(dbc_text)), parameters.parse(parameters_text))


def test_generated_files_are_up_to_date():
    for path, text in wire.outputs().items():
        assert path.read_text() == text, f"{path}: run python -m host.protocol.generate"


EXPANDED = wire_docs.expanded_dbc(dbc.load())


@pytest.mark.parametrize("text", [dbc.SOURCE.read_text(), EXPANDED], ids=["source", "expanded"])
def test_reader_agrees_with_cantools(text):
    library = {m.frame_id: m for m in cantools.database.load_string(text, "dbc").messages}
    ours = {m.identifier: m for m in dbc.parse(text)}
    assert library.keys() == ours.keys()
    for identifier, message in ours.items():
        theirs = {s.name: s for s in library[identifier].signals}
        assert (message.name, message.length) == (library[identifier].name, library[identifier].length)
        assert {s.name for s in message.signals} == theirs.keys()
        for s in message.signals:
            t = theirs[s.name]
            assert (s.start, s.length, s.signed, s.unit) == (t.start, t.length, t.is_signed, t.unit or "")
            assert (Fraction(t.scale), Fraction(t.offset)) == (s.factor, s.offset)
            assert (Fraction(t.minimum) / s.factor, Fraction(t.maximum) / s.factor) == (s.low, s.high)
            assert {raw: str(word) for raw, word in (t.choices or {}).items()} == dict(s.choices)


def test_fault_codes_have_their_words_wherever_they_are_sent():
    words = dict(dbc.fault_words())
    assert words[0] == "none"
    assert words[faults.FAULT_EMERGENCY_STOP] == "emergency_stop"
    assert len(words) == len(set(words.values())) == sum(n.startswith("FAULT_") for n in vars(faults)) - 1
    assert all(0 <= code <= 255 for code in words)
    library = cantools.database.load_string(EXPANDED, "dbc")
    for message, signal in (("fault_RL_calf", "code"), ("heartbeat_FR_hip", "fault")):
        choices = library.get_message_by_name(message).get_signal_by_name(signal).choices
        assert {raw: str(word) for raw, word in choices.items()} == words


def test_identifiers_stand_in_order_of_priority():
    bases = [m.identifier for m in dbc.load()]
    order = ["E_STOP", "SYNC", "SETPOINT_POSITION", "FAULT", "REPLY", "SLOW_STATUS", "HEARTBEAT", "SERVICE_REQUEST"]
    assert bases == sorted(bases)
    assert [getattr(names, f"{name}_ID") for name in order] == sorted(getattr(names, f"{name}_ID") for name in order)
    assert names.E_STOP_ID == 0


def test_hash_follows_the_meaning_only():
    assert number() == names.PROTOCOL_HASH
    assert number(TEXT.replace("Stiffness of impedance mode.", "Spring rate.")) == number()
    assert number(TEXT, PARAMETERS_TEXT.replace("default = 0", "default = 1", 1)) == number()
    for old, new in (
        ("SG_ tick : 32|30@1+", "SG_ tick : 33|30@1+"),
        ("SG_ code : 0|8@1+ (1,0) [0|255]", "SG_ code : 0|8@1+ (1,0) [0|254]"),
        ("(0.0625,0) [-255.9375|255.9375]", "(0.125,0) [-511.875|511.875]"),
        ('7 "fault" ;', '7 "failed" ;'),
        ('BA_ "Instances" BO_ 512 12', 'BA_ "Instances" BO_ 512 11'),
        ("BO_ 512 reply: 6", "BO_ 512 reply: 7"),
        ("overruns", "late_interrupts"),
    ):
        changed = TEXT.replace(old, new)
        assert changed != TEXT
        assert number(changed) != number(), old
    assert number(parameters_text=PARAMETERS_TEXT.replace('"node_id"', '"node_number"')) != number()


BAD_DBC = [
    ("SG_ code : 0|8@1+", "SG_ code : 0|8@0+", "big-endian"),
    ("SG_ code : 0|8@1+ (1,0)", "SG_ code : 0|8@1+ (0,0)", "factor 0"),
    ("SG_ value : 8|24@1-", "SG_ value : 7|24@1-", "overlaps"),
    ("SG_ value : 32|31@1-", "SG_ value : 32|32@1-", "32 bits"),
    ("SG_ tick : 32|30@1+", "SG_ tick : 32|31@1+", "31 bits"),
    ("SG_ tick : 32|30@1+", "SG_ tick : 40|30@1+", "leaves the frame"),
    ("[0|63.9375]", "[0|63.98]", "whole raw value"),
    ("[0|63.9375]", "[0|64]", "can't hold"),
    ('VAL_ 512 position -32768 "not_available"', 'VAL_ 512 position -32769 "not_available"', "outside its limits"),
    ("BO_ 512 reply: 6", "BO_ 512 reply: 9", "9 bytes"),
    ("BO_ 512 reply: 6", "BO_ 640 reply: 6", "given twice"),
    ('BA_ "Instances" BO_ 384 12', 'BA_ "Instances" BO_ 384 200', "already"),
    ("CM_ SG_ 128 counter", "CM_ SG_ 128 number", "no message or signal"),
    ("BU_: host joint", "SURPRISE", "can't read"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD_DBC)
def test_bad_dbc_is_refused_in_one_line(old, new, sentence):
    assert old in TEXT
    with pytest.raises(dbc.DbcError, match=sentence) as caught:
        dbc.parse(TEXT.replace(old, new))
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("joints.dbc: ")


def test_shared_codec_needs_equal_layouts():
    changed = TEXT.replace("SG_ slot_0 : 0|16@1- (0.0625,0) [0|2047.9375]", "SG_ slot_0 : 0|16@1- (0.0625,0) [0|2000]")
    with pytest.raises(ValueError, match="Codec gains differ in layout"):
        wire_codec.render(dbc.parse(changed))


def test_docs_need_every_marker():
    with pytest.raises(ValueError, match="found 0 times"):
        wire_docs.fill("no markers here", {"messages": "table"})


BAD_PARAMETERS = [
    ('name = "unique_id_0"', 'name = "node_id"', "given twice"),
    ("low = 0, high = 12, default = 0", "low = 0, high = 12, default = 13", "allowed low <= default <= high"),
    ("low = 0, high = 12,", "low = 0, high = 1073741824,", "allowed low <= default <= high"),
    ('access = "measured"', 'access = "sometimes"', "access one of"),
    ('access = "measured", ', "", "missing or unknown"),
    ('meaning = "', 'colour = "red", meaning = "', "missing or unknown"),
    ("raw_per_unit = 1000", "raw_per_unit = 0", "must be above 0"),
    ("low = 0, high = 12,", 'low = "0", high = 12,', "whole numbers"),
    ("default = 1, ", "default = 0, ", "a default other than 0"),
    ("count = 32", "count = 200", "allowed 1..256, once"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), BAD_PARAMETERS)
def test_bad_parameters_are_refused_in_one_line(old, new, sentence):
    assert old in PARAMETERS_TEXT
    with pytest.raises(parameters.ParameterError, match=sentence) as caught:
        parameters.parse(PARAMETERS_TEXT.replace(old, new, 1))
    assert "\n" not in str(caught.value)


def test_parameter_writes_are_refused_not_bent():
    for p in parameters.load():
        for armed in (0, 1):
            refused = {
                "measured": names.RESULT_READ_ONLY,
                "disarmed": names.RESULT_NEEDS_DISARMED if armed else names.RESULT_OK,
                "live": names.RESULT_OK,
            }[p.access]
            assert access.may_write(p.id, p.default, armed) == refused
            for raw in (p.low - 1, p.high + 1):
                expected = names.RESULT_OUT_OF_RANGE if refused == names.RESULT_OK else refused
                assert access.may_write(p.id, raw, armed) == expected
            if not p.zero and refused == names.RESULT_OK:
                assert access.may_write(p.id, 0, armed) == names.RESULT_OUT_OF_RANGE
        assert access.may_read(p.id) == names.RESULT_OK
        assert access.is_stored(p.id) == p.stored
        assert (table.PARAMETER_LOW[p.id], table.PARAMETER_HIGH[p.id]) == (p.low, p.high)
    for unknown in (-1, table.PARAMETERS, 255, 1 << 29):
        assert access.may_write(unknown, 0, 0) == names.RESULT_UNKNOWN_PARAMETER
        assert access.may_read(unknown) == names.RESULT_UNKNOWN_PARAMETER
        assert access.is_stored(unknown) == 0


def test_the_parameters_follow_the_joints_records():
    """Ids from current_kp and from pole_pairs on are the fields of two records: the application hands on a place."""
    names = [p.name for p in parameters.load()]
    assert names[table.PARAMETER_POLE_PAIRS :] == [name for name, _ in JointSettings.FIELDS]
    assert names[table.PARAMETER_CURRENT_KP : table.PARAMETER_THERMISTOR_RAW] == [n for n, _ in LoopSettings.FIELDS]


def values_of(blocks):
    """Return the values of a joint's settings by their names."""
    return {
        name: getattr(block, name) for block in (blocks.loop_settings, blocks.settings) for name, _ in block.FIELDS
    }


def test_defaults_are_the_robots_own_values():
    """But for what is measured on each joint: a fresh board is not commissioned."""
    blocks = joint_blocks(load_robot("parallel").actuator, JointSetup(-math.pi / 4, math.pi / 4))
    wanted = values_of(blocks)
    assert {p.name: p.default for p in parameters.load() if p.name in wanted} == wanted
    assert len(blocks.stored()) == table.PARAMETERS - table.PARAMETER_CURRENT_KP


def test_the_thermistors_points_are_one_block_as_the_application_keeps_them():
    by_name = {p.name: p.id for p in parameters.load()}
    assert by_name["thermistor_at_0"] == table.PARAMETER_THERMISTOR_RAW + CURVE_POINTS
    assert table.PARAMETER_POLE_PAIRS == table.PARAMETER_THERMISTOR_RAW + CURVE_SIZE


def test_the_robots_own_values_are_within_the_limits():
    robot = load_robot("parallel")
    by_name = {p.name: p for p in parameters.load()}
    joints = [(kind, pair) for leg in range(4) for kind, pair in enumerate(robot.joint_limits_rad(leg))]
    for kind, (low, high) in joints:
        blocks = joint_blocks(robot.actuator, JointSetup(low, high, has_joint_encoder=kind != 1))
        values = values_of(blocks)
        values |= {f"thermistor_raw_{i}": raw for i, raw in enumerate(blocks.curve[:CURVE_POINTS])}
        values |= {f"thermistor_at_{i}": raw for i, raw in enumerate(blocks.curve[CURVE_POINTS:])}
        for name, raw in values.items():
            assert access.may_write(by_name[name].id, raw, 0) == names.RESULT_OK, (name, raw)


def test_parameter_values_keep_their_unit():
    for p in parameters.load():
        if p.access == "measured":
            with pytest.raises(parameters.ParameterError, match="can only be read"):
                p.to_raw(p.to_value(p.default))
            continue
        for raw in (p.low, p.default, p.high):
            assert p.to_raw(p.to_value(raw)) == raw
        for value in (p.to_value(p.high + 1), float("nan"), float("inf"), *(() if p.zero else (0.0,))):
            with pytest.raises(parameters.ParameterError, match=": allowed "):
                p.to_raw(value)
