"""MCAP files that are well formed and yet not what a record is: each a name and how it is written."""

import json
import random
import struct
from copy import deepcopy

from mcap.writer import CompressionType, Writer

from host.records.channels import CHANNELS
from shared.body.params import Params
from shared.record import pack

PARAMS = len(pack(Params()))
ABOUT = {"robot": "caramelo", "rate_hz": "50", "params": " ".join(["1"] * PARAMS), "core": "0"}
START_NS = 1_700_000_000_000_000_000


def good_values(topic, tick):
    """Return values as the channel's schema has them."""
    plain = {"number": 0.25, "integer": tick, "string": "walking", "boolean": True}
    made = {}
    for name, rule in CHANNELS[topic].items():
        many = rule["type"] == "array"
        made[name] = [plain[rule["items"]["type"]]] * rule["maxItems"] if many else plain[rule["type"]]
    return made


def drive(ticks=20):
    """Return the messages of a short drive."""
    return [(topic, good_values(topic, tick)) for tick in range(ticks) for topic in CHANNELS]


def mcap(path, messages, about=ABOUT, encoding="json", schema=True, times_ns=None, compression=CompressionType.ZSTD,
         chunked=True, channels_each=1):  # fmt: skip
    """Write a file of (topic, values); values may be bytes. ``times_ns``: a function of the message's number."""
    with path.open("wb") as file:
        writer = Writer(file, compression=compression, use_chunking=chunked)
        writer.start(profile="", library="test")
        if about is not None:
            writer.add_metadata("robot", about)
        ids = {}
        for number, (topic, values) in enumerate(messages):
            data = values if isinstance(values, bytes) else json.dumps(values).encode()
            if topic not in ids:
                shape = writer.register_schema(topic, "jsonschema", b"{}") if schema else 0
                ids[topic] = [writer.register_channel(topic, encoding, shape) for _ in range(channels_each)]
            time_ns = times_ns(number) if times_ns else START_NS + number * 20_000_000
            channels = ids[topic]
            writer.add_message(channels[number % len(channels)], time_ns, data, time_ns, 0)
        writer.finish()
    return path


WRONG = [None, True, "text", 3, -1, 1.5, 10**400, -(10**400), 2**63, [], [1], [None] * 12, ["x"] * 12, [[1]] * 12,
         [float("nan")] * 12, [float("inf")] * 6 + [float("-inf")] * 6, [1e308] * 12, [-1e308, 1e308] * 6,
         [10**400] * 12, [2**31] * 12, [1] * 100, {}, {"x": {"y": 1}}, float("nan"), float("inf"), 1e308,
         "\x1b[2J\x9b", "[/red]$\\frac$", "\ud800", "a" * 100_000, "\x00", "$", "\n" * 50, "漢字"]  # fmt: skip
RAW = [b"", b"null", b"[]", b"3", b"{", b"\xff\xfe", b"[" * 100_000, b'{"a":' * 50_000, b'{"state":1}', b"NaN",
       b'{"tick": ' + b"9" * 5000 + b"}", b"\x00" * 100, b'{"a":1,"a":2}']  # fmt: skip
TOPICS = ["", "/", "/../X", "../../X", "/a/b", "..", "/.", "/\x1b[2J", "x" * 300, "/" + "x" * 250, "\x00", "/[/red]",
          "a\nb", "//planner", "planner", "/etc/passwd", "~", "/C:\\x", "/x%2Fy", "/ä"]  # fmt: skip


def whole_files(folder):
    """Yield (name, file) of odd files."""
    many = drive()
    yield "nothing but the robot", mcap(folder / "a.mcap", [])
    yield "no robot", mcap(folder / "b.mcap", many, about=None)
    yield "an empty robot", mcap(folder / "c.mcap", many, about={})
    yield "no schemas", mcap(folder / "d.mcap", many, schema=False)
    yield "an encoding nobody knows", mcap(folder / "e.mcap", many, encoding="protobuf")
    yield "no encoding", mcap(folder / "f.mcap", many, encoding="")
    yield "two channels of each topic", mcap(folder / "g.mcap", many, channels_each=2)
    yield "no chunks", mcap(folder / "h.mcap", many, chunked=False)
    yield "lz4", mcap(folder / "i.mcap", many, compression=CompressionType.LZ4)
    yield "not compressed", mcap(folder / "j.mcap", many, compression=CompressionType.NONE)
    yield "all at once", mcap(folder / "k.mcap", many, times_ns=lambda n: START_NS)
    yield "backwards", mcap(folder / "l.mcap", many, times_ns=lambda n: START_NS - n * 10**9)
    yield "from 0 to the end of time", mcap(folder / "m.mcap", many, times_ns=lambda n: (2**64 - 1) * (n % 2))
    for number, value in enumerate(["", "x", "1 2 3", " ".join(["99999999999"] * PARAMS), " ".join(["0"] * PARAMS),
                                    " ".join(["-1"] * PARAMS), " ".join(["2147483647"] * PARAMS), "9" * 5000]):
        yield f"parameters {value[:20]}", mcap(folder / f"n{number}.mcap", many, about={**ABOUT, "params": value})
    obeyed = {**ABOUT, "robot": "\x1b[2J[/x]$\\z\x9b"}
    yield "a robot's name that is obeyed", mcap(folder / "o.mcap", many, about=obeyed)
    for number, topic in enumerate(TOPICS):
        yield f"topic {topic[:10]!r}", mcap(folder / f"p{number}.mcap", [*many, (topic, {"x": 1})])
    yield "two topics of one name", mcap(folder / "q.mcap", [*many, ("planner", {"x": 1})])
    for number, raw in enumerate(RAW):
        yield f"raw {raw[:10]!r}", mcap(folder / f"r{number}.mcap", [*many, ("/state", raw)])
        yield f"raw {raw[:10]!r} elsewhere", mcap(folder / f"s{number}.mcap", [*many, ("/elsewhere", raw)])
    one = [("/elsewhere", {"x": 1}), ("/elsewhere", {"y": 1})]
    yield "other values in each message", mcap(folder / "t.mcap", [*many, *one])
    states = [("/state", {"state": f"s{n}", "reason": ""}) for n in range(999)]
    yield "a thousand states", mcap(folder / "u.mcap", states)


def odd_values(folder, seed, count):
    """Yield (name, file) with one value of one message replaced by another kind, drawn from a seed."""
    rng = random.Random(seed)
    for number in range(count):
        messages = deepcopy(drive(6))
        topic, values = messages[rng.randrange(len(messages))]
        name = rng.choice([*values, "another"])
        value = rng.choice(WRONG)
        if rng.random() < 0.15:
            values.pop(name, None)
        elif isinstance(values.get(name), list) and rng.random() < 0.5:
            values[name][rng.randrange(len(values[name]))] = value
        else:
            values[name] = value
        yield f"{topic} {name} = {str(value)[:30]}", mcap(folder / f"{number}.mcap", messages)


def damaged(folder, seed, count):
    """Yield (name, file) of a file without check sums, with bytes overwritten, lengths above all."""
    rng = random.Random(seed)
    data = mcap(folder / "good.mcap", drive(4), compression=CompressionType.NONE).read_bytes()
    for number in range(count):
        spoilt = bytearray(data)
        for _ in range(rng.randrange(1, 4)):
            at = rng.randrange(8, len(spoilt) - 8)
            kind = rng.randrange(3)
            if kind == 0:
                spoilt[at] = rng.randrange(256)
            elif kind == 1:
                length = rng.choice([0, 1, 2**31, 2**63 - 1, 2**64 - 1, rng.getrandbits(64)])
                spoilt[at : at + 8] = struct.pack("<Q", length)
            else:
                del spoilt[at : at + rng.randrange(1, 40)]
        path = folder / f"{number}.mcap"
        path.write_bytes(spoilt)
        yield f"damage {number}", path
