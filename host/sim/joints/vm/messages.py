"""The messages between host and VM over the pipe, little-endian; runs on both.

A request is a kind, its length, and its body; every request gets one answer. ``boot`` is JSON, because it is rare.
"""

import struct

from .inside import Inside

HEAD = "<BH"  # kind, length of the body
BOOT, FRAME, TICK = 1, 2, 3
FRAME_BODY = "<HBB8s"  # identifier, length, room, data
TICK_BODY = "<qHHHHHHHBB"  # time in us, bus, thermistor, mcu, joint, raw a b c, room, number of rotor readings
ANSWER = "<BHiBB"  # bridge, resets, q_ref, number of filters (255: as they were), number of frames
FILTER = "<HH"
SENT = "<HB8s"  # identifier, length, data
UNCHANGED = 255

ANSWER_SIZE = struct.calcsize(ANSWER)
FILTER_SIZE = struct.calcsize(FILTER)
SENT_SIZE = struct.calcsize(SENT)
TICK_SIZE = struct.calcsize(TICK_BODY)


def pack_answer(inside: Inside, known) -> bytes:  # type: ignore[no-untyped-def]
    """Return the answer after a request; ``known`` are the filters told last."""
    frames = inside.sent()
    changed = inside.pairs is not known
    filters = len(inside.pairs) if changed else UNCHANGED
    answer = struct.pack(ANSWER, inside.bridge, inside.resets, inside.q_ref, filters, len(frames))
    if changed:
        for wanted, mask in inside.pairs:
            answer += struct.pack(FILTER, wanted, mask)
    for identifier, data in frames:
        answer += struct.pack(SENT, identifier, len(data), data)
    return answer
