"""Foxglove's server: python -m host.teleop.foxglove FD, started by side.py with its end of their common socket."""

import asyncio
import sys

from ...control.priority import give_back

NICER = 5  # than a loop that nobody lifted above the others (chosen)

if __name__ == "__main__":
    give_back(NICER)
    from .process import main

    asyncio.run(main(int(sys.argv[1])))
