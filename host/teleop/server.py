"""A server's process: python -m host.teleop.server FOLDER FD, started by side.py with its end of their common socket.

FOLDER is ``web`` or ``foxglove``; its process.py serves.
"""

import asyncio
import importlib
import sys

from ..control.priority import give_back

NICER = 5  # than a loop at ordinary priority (chosen)

if __name__ == "__main__":
    give_back(NICER)  # before the imports below, which take almost a second
    from .link import converse

    server = importlib.import_module(f"{__package__}.{sys.argv[1]}.process")
    asyncio.run(converse(int(sys.argv[2]), server.serve))
