"""The VM's end of the pipe: a line of JSON with what to do, a line with what it has left, until the input ends.

What to do is a method of Inside and its arguments; the first line is the board's unique id.
"""

import json
import sys

from .inside import Inside


def serve() -> None:
    """Be one joint. An exception ends it: the VM writes it to the error output."""
    inside = Inside(bytes(json.loads(sys.stdin.readline())))
    line = sys.stdin.readline()
    while line:
        method, arguments = json.loads(line)
        getattr(inside, method)(*arguments)
        frames = [(identifier, list(data)) for identifier, data in inside.sent()]
        left = [inside.bridge, inside.q_ref, inside.resets, inside.pairs, frames]
        sys.stdout.write(json.dumps(left) + "\n")
        line = sys.stdin.readline()
