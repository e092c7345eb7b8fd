"""A running `caramelo teleop --sim --direct --web` in processes of its own, and a script that watches it."""

import contextlib

from host.lab.teleop.watched import Watched


class Teleop(Watched):
    """Without the servo bus in between, which a busy machine can't serve in time."""

    def __init__(self, folder, *options, sim=("--sim", "--direct", "--in", "plane"), host="127.0.0.1"):
        super().__init__(folder, *options, sim=sim, host=host)

    def __exit__(self, *error):
        """End it; stopped before, it ends at once instead of sitting down."""
        with contextlib.suppress(OSError):
            self.say(type="stop")
        super().__exit__(*error)
