"""When a run is over, and why, in a sentence with numbers."""

import math
from dataclasses import dataclass

FALL_RAD = math.radians(60.0)
# Less than this gained in the whole of ``stuck_after_s`` counts as standing still.
STUCK_GAIN_M = 0.005


@dataclass(frozen=True)
class Outcome:
    """How a run ended: arrived, completed (its time, without a distance), fell, stuck, timeout; and a sentence."""

    kind: str
    sentence: str

    @property
    def ok(self) -> bool:
        """True if the robot did what was commanded."""
        return self.kind in ("arrived", "completed")


class Referee:
    """Decides when a run is over and says so in a sentence with numbers; a tilt beyond ``fall_rad`` is a fall."""

    def __init__(
        self,
        start_x_m: float,
        distance_m: float | None,
        duration_s: float,
        stuck_after_s: float,
        fall_rad: float = FALL_RAD,
    ) -> None:
        self._start_x_m, self._distance_m = start_x_m, distance_m
        self._duration_s, self._stuck_after_s, self._fall_rad = duration_s, stuck_after_s, fall_rad
        self._best_m, self._best_at_s = 0.0, 0.0
        self._done = 0.0

    def progress(self, time_s: float, x_m: float) -> float:
        """Share of the run that is done, 0 .. 1, never falling: of the distance or the time, whichever is further."""
        by_time = time_s / self._duration_s
        by_distance = (x_m - self._start_x_m) / self._distance_m if self._distance_m else 0.0
        self._done = min(max(by_time, by_distance, self._done), 1.0)
        return self._done

    def judge(self, time_s: float, x_m: float, tilt_rad: float, torso_touches: bool) -> Outcome | None:
        """Return how the run ended, or None while it goes on; raise ArithmeticError if the numbers ran away.

        ``tilt_rad``: how far the torso's up leans, >= 0.
        """
        if not math.isfinite(x_m + tilt_rad):
            raise ArithmeticError(f"simulation at {time_s:.2f} s: x = {x_m}; a drive is too strong for the sub-step")
        gone = x_m - self._start_x_m
        where = f"at {time_s:.2f} s, {gone:.3f} m on"
        tilt = f"tilt {math.degrees(tilt_rad):.0f} deg"
        if tilt_rad > self._fall_rad:
            return Outcome("fell", f"fell {where}: {tilt}")
        if torso_touches:
            return Outcome("fell", f"fell {where}: the torso touched the ground, {tilt}")
        if self._distance_m is None:
            return Outcome("completed", f"ran {time_s:.2f} s, {gone:.3f} m on") if self._over(time_s) else None
        if gone >= self._distance_m:
            return Outcome("arrived", f"arrived after {time_s:.2f} s, {gone:.3f} m on")
        if self._over(time_s):
            return Outcome("timeout", f"timed out {where} of {self._distance_m:.3f} m")
        return self._stuck(time_s, gone)

    def _over(self, time_s: float) -> bool:
        return time_s >= self._duration_s - 1e-9

    def _stuck(self, time_s: float, gone_m: float) -> Outcome | None:
        if gone_m > self._best_m + STUCK_GAIN_M:
            self._best_m, self._best_at_s = gone_m, time_s
        if time_s - self._best_at_s < self._stuck_after_s:
            return None
        waited = time_s - self._best_at_s
        return Outcome("stuck", f"stuck at {gone_m:.3f} m of {self._distance_m:.3f} m: no gain for {waited:.0f} s")
