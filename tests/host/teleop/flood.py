"""Pours connections into the page's port and resets into the scripts' socket until stdin ends; a process of its own.

python -m tests.host.teleop.flood PORT PATH. A line on stdout says about once a second how many it has opened so far.
"""

import json
import random
import select
import socket
import sys
import time
from itertools import count

CONNECTIONS, SCRIPTS = 200, 3
KEPT_S = 0.2  # a connection that is not ended by the other side is ended and opened again
RESETS = json.dumps({"type": "reset"}).encode() + b"\n"
CHANCE = random.Random("flood")


class Stream:
    """One connection that is opened again whenever it ends; ``say`` returns what it pours in."""

    def __init__(self, family, where, say, kept_s):
        self.family, self.where, self.say, self.kept_s = family, where, say, kept_s
        self.opened = 0
        self.open()

    def open(self):
        self.socket = socket.socket(self.family)
        self.socket.setblocking(False)
        self.socket.connect_ex(self.where)
        self.end_s = time.monotonic() + CHANCE.uniform(0.5, 1.0) * self.kept_s
        self.opened += 1

    def pour(self):
        """Say as much as is taken."""
        now_s = time.monotonic()
        try:
            self.socket.send(self.say())
        except BlockingIOError:
            pass
        except OSError:
            self.end_s = min(self.end_s, now_s + 0.05)
        if now_s >= self.end_s:
            self.socket.close()
            self.open()


def request():
    """Return some of a request, or nothing but noise."""
    return CHANCE.choice([b"GET / HTTP/1.1\r\nHost: x\r\n", b"POST /pair HTTP/1.1\r\n\r\n", CHANCE.randbytes(300)])


def main(port, path):
    where = ("127.0.0.1", int(port))
    streams = [Stream(socket.AF_INET, where, request, KEPT_S) for _ in range(CONNECTIONS)]
    streams += [Stream(socket.AF_UNIX, path, lambda: 100 * RESETS, 1e9) for _ in range(SCRIPTS)]
    for turn in count():
        if select.select([sys.stdin], [], [], 0.02)[0]:
            break
        for stream in streams:
            stream.pour()
        if turn % 50 == 0:
            counts = [sum(each.opened for each in part) for part in (streams[:CONNECTIONS], streams[CONNECTIONS:])]
            print(json.dumps(dict(zip(("connections", "scripts"), counts, strict=True))), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
