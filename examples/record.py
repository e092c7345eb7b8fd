"""Record a walk into an MCAP file, for Foxglove, PlotJuggler, or `caramelo log plot walk.mcap`."""

import sys
from pathlib import Path

from caramelo import Robot

path = Path("walk.mcap")
path.unlink(missing_ok=True)
with Robot(*sys.argv[1:], record=path) as robot:
    robot.stand()
    robot.walk(0.05, seconds=4)
print(f"wrote {path}, {path.stat().st_size // 1000} kB")
