"""The VM's end of the pipe: takes requests on its input and answers on its output until the input ends."""

import json
import struct
import sys

from .inside import Inside
from .messages import BOOT, FRAME, FRAME_BODY, HEAD, TICK, TICK_BODY, TICK_SIZE, pack_answer


def _boot(inside, body):  # type: ignore[no-untyped-def]
    order = json.loads(body)
    inside = inside or Inside(bytes(order["unique_id"]))
    inside.boot(*order["arguments"])
    return inside


def _tick(inside, body):  # type: ignore[no-untyped-def]
    now_us, bus, thermistor, mcu, joint, a, b, c, room, count = struct.unpack_from(TICK_BODY, body, 0)
    rotors = [body[TICK_SIZE + 2 * i] | body[TICK_SIZE + 2 * i + 1] << 8 for i in range(count)]
    inside.tick(now_us, (bus, thermistor, mcu), rotors, joint, (a, b, c), room)


def _do(inside, kind, body):  # type: ignore[no-untyped-def]
    if kind == BOOT:
        return _boot(inside, body)
    if kind == FRAME:
        identifier, size, room, data = struct.unpack(FRAME_BODY, body)
        inside.frame(identifier, data[:size], room)
    elif kind == TICK:
        _tick(inside, body)
    return inside


def serve() -> None:
    """Be one joint; an exception goes to the error output, because the output carries answers."""
    try:
        _serve(sys.stdin.buffer, sys.stdout.buffer)
    except Exception as error:
        sys.print_exception(error, sys.stderr)  # type: ignore[attr-defined]
        sys.exit(1)


def _serve(source, sink):  # type: ignore[no-untyped-def]
    inside = None
    known = None
    while True:
        head = source.read(struct.calcsize(HEAD))
        if not head:
            return
        kind, length = struct.unpack(HEAD, head)
        inside = _do(inside, kind, source.read(length))
        sink.write(pack_answer(inside, known))
        known = inside.pairs
