"""How much of a CAN bus a schedule takes: exact length of classic 11-bit frames, bit stuffing and CRC included.

Frame format: ISO 11898-1, base format. Stuffed: start of frame, identifier, control, data and CRC, 34 + 8 n bits
for n bytes; after each five equal bits comes one of the other value, which counts in the next five. Not stuffed:
CRC delimiter, acknowledge (2), end of frame (7), and the intermission (3) before the next frame.
Worst case: a stuff bit after the first five bits and then after every four, floor((34 + 8 n - 1) / 4).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

from shared.wire import names
from shared.wire.framing import NODES

from ...protocol import frames
from .port import BITRATE

_STUFFED_OVERHEAD = 34  # SOF 1, identifier 11, RTR, IDE, r0, DLC 4, CRC 15
_UNSTUFFED = 10 + 3  # CRC delimiter, ACK slot and delimiter, EOF 7; intermission 3
_CRC15 = 0x4599  # ISO 11898-1: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
_STATUS_HZ = 5.0  # slow status and heartbeat
_CYCLE_SAMPLES = 50
_HIP_SHARE = 512  # of the other joints' swing when walking straight on


def crc15(bits: Iterable[int]) -> int:
    """CRC-15/CAN of a sequence of bits, 0 .. 0x7FFF."""
    crc = 0
    for bit in bits:
        crc = (crc << 1 & 0x7FFF) ^ (_CRC15 if (crc >> 14) ^ bit else 0)
    return crc


def bits_of(value: int, width: int) -> list[int]:
    """The lowest bits of a number, the highest of them first."""
    return [value >> place & 1 for place in range(width - 1, -1, -1)]


def stuffed_region(identifier: int, data: bytes) -> list[int]:
    """The bits of a frame from start of frame to the end of its CRC, before stuffing."""
    if not 0 <= identifier <= 0x7FF or len(data) > 8:
        raise ValueError(f"identifier {identifier:#x} with {len(data)} bytes: allowed 0..0x7ff with 0..8 bytes")
    header = [0, *bits_of(identifier, 11), 0, 0, 0, *bits_of(len(data), 4)]
    body = header + [bit for byte in data for bit in bits_of(byte, 8)]
    return body + bits_of(crc15(body), 15)


# State of the stuffing: 2 x (equal bits so far - 1) + the last bit
_IDLE = 1  # the bus is recessive before a frame


@cache
def _stuffed_byte(state: int, byte: int, width: int = 8) -> tuple[int, int]:
    """Return how many stuff bits ``width`` bits get after a state, and the state after them."""
    run, last, count = state // 2 + 1, state % 2, 0
    for bit in bits_of(byte, width):
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            count, run, last = count + 1, 1, 1 - bit
    return count, 2 * (run - 1) + last


@cache
def _crc_byte(high: int) -> int:
    """Return what eight bits shifted out of the CRC contribute to it."""
    return crc15(bits_of(high, 8))


@cache
def _head(identifier: int, length: int) -> tuple[int, int, int]:
    """Return the CRC and the stuff bits of the 19 bits before a frame's data, and the state after them."""
    bits = stuffed_region(identifier, bytes(length))[:19]
    count, state = 0, _IDLE
    for bit in bits:
        more, state = _stuffed_byte(state, bit, 1)
        count += more
    return crc15(bits), count, state


def frame_bits(identifier: int, data: bytes) -> int:
    """Bits that a frame takes on the bus, intermission included."""
    crc, count, state = _head(identifier, len(data))
    for byte in data:
        more, state = _stuffed_byte(state, byte)
        count += more
        crc = (crc << 8 & 0x7FFF) ^ _crc_byte(crc >> 7 ^ byte)
    more, state = _stuffed_byte(state, crc >> 7)
    count += more + _stuffed_byte(state, crc & 0x7F, 7)[0]
    return _STUFFED_OVERHEAD + 8 * len(data) + count + _UNSTUFFED


def worst_bits(length: int) -> int:
    """Most bits that a frame of ``length`` bytes can take, intermission included."""
    region = _STUFFED_OVERHEAD + 8 * length
    return region + (region - 1) // 4 + _UNSTUFFED


@dataclass(frozen=True)
class Scheduled:
    """``samples`` frames (identifier, data) stand for what is sent ``rate_hz`` times a second in all."""

    name: str
    rate_hz: float
    samples: tuple[tuple[int, bytes], ...]

    @property
    def length(self) -> int:
        return max(len(data) for _, data in self.samples)


@dataclass(frozen=True)
class LoadRow:
    """One line of the answer; shares are of the whole bus, 1 = full. The total has length 0 and mean bits."""

    name: str
    length: int
    frames_per_s: float
    worst_bits: float
    typical_bits: float
    worst_share: float
    typical_share: float


def busload(schedule: Sequence[Scheduled], bitrate: int = BITRATE) -> list[LoadRow]:
    """Return a row per scheduled message and a last row ``total``.

    Typical is the mean over the samples of the frames' exact lengths.
    """
    rows = []
    for item in schedule:
        worst = worst_bits(item.length)
        typical = sum(frame_bits(*sample) for sample in item.samples) / len(item.samples)
        rate = item.rate_hz / bitrate
        rows.append(LoadRow(item.name, item.length, item.rate_hz, worst, typical, worst * rate, typical * rate))
    frames_per_s = sum(row.frames_per_s for row in rows)
    worst_share, typical_share = sum(row.worst_share for row in rows), sum(row.typical_share for row in rows)
    per_frame = bitrate / frames_per_s if frames_per_s else 0.0
    bits = (worst_share * per_frame, typical_share * per_frame)
    return [*rows, LoadRow("total", 0, frames_per_s, *bits, worst_share, typical_share)]


def _swing(step: int, joint: int, size: int) -> int:
    """A walking joint's value at a sample of one gait cycle: a sine with its own phase and centre; hips hardly move."""
    if joint % 3 == 1:
        size //= _HIP_SHARE
    return round(size * (0.3 * math.sin(2 * math.pi * (step / _CYCLE_SAMPLES + joint / 12)) + 0.4 * math.cos(joint)))


def _encoded(identifier: int, rows: Iterable[list[int]]) -> tuple[tuple[int, bytes], ...]:
    return tuple((identifier, frames.encode(identifier, row)[0]) for row in rows)


def _group_cycle(identifier: int, group: int, nodes: Sequence[int], size: int) -> tuple[tuple[int, bytes], ...]:
    """Set-points of one group over one gait cycle; joints on another bus have "no change" in their slots."""
    slots = range(4 * group + 1, 4 * group + 5)
    rows = ([_swing(t, n, size) if n in nodes else names.NO_CHANGE for n in slots] for t in range(_CYCLE_SAMPLES))
    return _encoded(identifier, rows)


def _reply_cycle(node: int) -> tuple[tuple[int, bytes], ...]:
    """Replies of one joint over one gait cycle: position, velocity, current."""
    steps = range(_CYCLE_SAMPLES)
    rows = ([_swing(t, node, 8192), _swing(t, node + 3, 512), _swing(t, node + 6, 8192)] for t in steps)
    return _encoded(names.REPLY_ID + node, rows)


# Set-point kinds by name: base identifier and typical size in raw units
SETPOINTS = {
    "position": (names.SETPOINT_POSITION_ID, 8192),
    "velocity": (names.SETPOINT_VELOCITY_ID, 2048),
    "current": (names.SETPOINT_CURRENT_ID, 4096),
    "impedance": (names.SETPOINT_IMPEDANCE_ID, 8192),
}


def _setpoint(kind: str, nodes: Sequence[int], rate_hz: float) -> Scheduled:
    base, size = SETPOINTS[kind]
    groups = sorted({(node - 1) // 4 for node in nodes})
    samples = tuple(sample for group in groups for sample in _group_cycle(base + 8 * group, group, nodes, size))
    return Scheduled(f"set-point {kind}", rate_hz * len(groups), samples)


def _per_joint(name: str, base: int, nodes: Sequence[int], rate_hz: float, rows: list[list[int]]) -> Scheduled:
    samples = tuple(sample for node in nodes for sample in _encoded(base + node, rows))
    return Scheduled(name, rate_hz * len(nodes), samples)


def default_schedule(
    rate_hz: float = 200.0,
    nodes: Sequence[int] = tuple(range(1, 13)),
    setpoints: Sequence[str] = ("position",),
) -> list[Scheduled]:
    """What the host and ``nodes`` (1 .. 12) send on one bus: SYNC, set-points and replies at ``rate_hz``, status."""
    unknown = [kind for kind in setpoints if kind not in SETPOINTS]
    if unknown or not nodes or any(not 1 <= node <= NODES for node in nodes):
        raise ValueError(f"set-points {unknown}, or no node 1..12: allowed {', '.join(SETPOINTS)}")
    sync = Scheduled("SYNC", rate_hz, _encoded(names.SYNC_ID, ([counter, 0x5A] for counter in range(256))))
    replies = tuple(sample for node in nodes for sample in _reply_cycle(node))
    status = [[25 * 16 + i, 30 * 16 + i, 24 * 16 - i % 8, 0, 0, 0] for i in range(_CYCLE_SAMPLES)]
    alive = [[names.STATE_OPERATION_ENABLED, names.MODE_POSITION, 0, names.PROTOCOL_HASH, 0x5A, 0x3FA81C]]
    return [
        sync,
        *(_setpoint(kind, nodes, rate_hz) for kind in setpoints),
        Scheduled("reply", rate_hz * len(nodes), replies),
        _per_joint("slow status", names.SLOW_STATUS_ID, nodes, _STATUS_HZ, status),
        _per_joint("heartbeat", names.HEARTBEAT_ID, nodes, _STATUS_HZ, alive),
    ]
