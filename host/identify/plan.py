"""A joint's test motions: runs at a limited duty, coasting, turning back, small steps, chirps, slow sweeps.

All in angles of the servo's shaft. A run at a limited duty is a far goal with a small Goal PWM: the servo pushes with
exactly that duty until it nears the goal, where it stops by itself. So the duty is known to 1/885; from the P law it
would be known only to a step of the position, 0.75 %.
"""

from dataclasses import dataclass
from math import pi, sin

from .model import Load

TICK_S = 0.005  # a request every 5 ms: one answer of 32 bytes and the adapter's 1 ms fit in four times (chosen)
REACH_RAD = 0.5  # to either side of the centre: 29 deg (chosen)
MOST = 0.5  # of the stall torque: limit for moving joints on the stand (chosen)
STEPS_MOST = 0.5  # limit for small steps and chirps, which move only a few degrees (chosen)
RUNS = (0.07, 0.09, 0.11, 0.14, 0.18, 0.24, 0.32, 0.42)  # duties of single runs; friction takes 2 .. 8 %
HARD = 0.25  # duty from which a turning joint bounces within its play (seen)
FALLS_RAD_S2 = 5.0  # with this a link falls through 1.5 deg of play in 0.1 s, and settles before its sweep (chosen)
COASTS = (0.5, 0.45, 0.35, 0.25)  # duties before the torque is taken away


@dataclass(frozen=True)
class Move:
    """From ``at_s`` on: the goal, and the duty's limit; None: no torque."""

    at_s: float
    goal_rad: float
    most: float | None


@dataclass(frozen=True)
class Sweep:
    """One excitation, which begins at rest at ``start_rad``."""

    name: str
    start_rad: float
    duration_s: float
    moves: tuple[Move, ...]


def plan(centre_rad: float, reach_rad: float, load: Load) -> list[Sweep]:
    """Return the sweeps of one joint in the air, within ``reach_rad`` of the centre."""
    ends = {way: _settled_rad(centre_rad, centre_rad - way * reach_rad * 0.95, load) for way in (1, -1)}
    sweeps = [_run(ends[way], centre_rad + way * reach_rad, way, duty) for duty in RUNS for way in (1, -1)]
    sweeps += [_coast(ends[way], centre_rad + way * reach_rad, way, duty) for duty in COASTS for way in (1, -1)]
    sweeps += [_ramp(centre_rad, way) for way in (1, -1)]
    for duty, turn_s in ((0.4, 0.1), (0.3, 0.12), (0.2, 0.12), (0.12, 0.15)):
        sweeps += [_back_and_forth(centre_rad, reach_rad, way, duty, turn_s) for way in (1, -1)]
    sweeps += [_steps(centre_rad), _chirp(centre_rad, 1), _chirp(centre_rad, -1), _slow(centre_rad)]
    return sweeps


def _settled_rad(centre: float, far: float, load: Load) -> float:
    """Return the farthest place where the weight lays the link on a flank; near its balance it rattles in its play."""
    places = [far + part / 20 * (centre - far) for part in range(20)]
    laid = [at for at in places if abs(load.at_scalar(at)) > FALLS_RAD_S2 * load.inertia_kg_m2]
    return laid[0] if laid else far


def _run(start: float, end: float, way: int, duty: float) -> Sweep:
    return Sweep(f"run {way * duty:+.2f}", start, 0.9 if duty < 0.3 else 0.5, (Move(0.0, end, duty),))


def _coast(start: float, end: float, way: int, duty: float) -> Sweep:
    free_s = 0.055 / duty + 0.03  # after about 0.3 rad
    moves = (Move(0.0, end, duty), Move(free_s, end, None), Move(free_s + 0.3, start, 0.1))
    return Sweep(f"coast {way * duty:+.2f}", start, free_s + 0.3, moves)


def _ramp(centre: float, way: int) -> Sweep:
    """Duty grows by 1/885 in 10 ms until the joint breaks loose."""
    moves = tuple(Move(0.01 * k, centre + way * 0.3, k / 885) for k in range(110))
    return Sweep(f"ramp {'+' if way > 0 else '-'}", centre, 1.1, moves)


def _back_and_forth(centre: float, reach: float, way: int, duty: float, turn_s: float) -> Sweep:
    ends = (centre + way * reach, centre - way * reach)
    moves = tuple(Move(k * turn_s if k == 0 else (k - 0.5) * turn_s, ends[k % 2], duty) for k in range(7))
    name = "hard turns" if duty >= HARD else "back and forth"
    return Sweep(f"{name} {way * duty:+.2f}", centre, 7 * turn_s, moves)


def _steps(centre: float) -> Sweep:
    places = (0.06, 0.0, -0.06, 0.0, 0.1, -0.1)
    return Sweep("steps", centre, 1.2, tuple(Move(0.2 * k, centre + x, STEPS_MOST) for k, x in enumerate(places)))


def _chirp(centre: float, way: int) -> Sweep:
    """From 1 to 9 Hz in 1.2 s, 3 degrees."""
    times = [TICK_S * k for k in range(240)]
    moves = tuple(Move(t, centre + way * 0.055 * sin(2 * pi * (t + 8 * t * t / 2.4)), STEPS_MOST) for t in times)
    return Sweep(f"chirp {'+' if way > 0 else '-'}", centre, 1.2, moves)


def _slow(centre: float) -> Sweep:
    """There and back at 0.15 rad/s, as the P law does it."""
    times = [TICK_S * k for k in range(240)]
    moves = tuple(Move(t, centre + 0.09 - 0.15 * abs(t - 0.6), STEPS_MOST) for t in times)
    return Sweep("slow", centre, 1.2, moves)
