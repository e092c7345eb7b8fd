"""The web process: python -m host.teleop.web FD, started by webside.py with its end of their common socket."""

import asyncio
import sys

from ...control.priority import give_back

NICER = 5  # than a loop that nobody lifted above the others (chosen)

if __name__ == "__main__":
    give_back(NICER)  # before the imports below, which take the better part of a second
    from .process import main

    asyncio.run(main(int(sys.argv[1])))
