"""Paper A's balance in floats: a PID each for roll and pitch, the sum of their outputs' sizes limited."""

import math

from .fixed import towards
from .pid import Pid

ERROR_MAX_RAD = 8191 * 2 * math.pi / 65536  # 45 degrees


class Balance:
    """``gains``: what Pid takes."""

    def __init__(self, gains):
        self.pids = [Pid(*gains), Pid(*gains)]
        self.limit = self.pids[0].output_max
        self.correction = [0.0, 0.0]

    def step(self, wanted, measured):
        """Take commanded and measured (roll, pitch) and return the correction of both."""
        raw = [pid.step(w, m, ERROR_MAX_RAD) for pid, w, m in zip(self.pids, wanted, measured)]
        size = abs(raw[0]) + abs(raw[1])
        share = self.limit / size if size > self.limit else 1.0
        self.correction = [share * value for value in raw]
        return self.correction

    def release(self, step):
        """Let the correction fade and forget what was learnt."""
        for pid in self.pids:
            pid.reset()
        self.correction = [towards(value, 0.0, step) for value in self.correction]
        return self.correction
