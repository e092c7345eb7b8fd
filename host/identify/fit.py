"""Finds the numbers with which the model moves as the joint did: least squares with scipy, one joint at a time.

The unknowns are the numbers of model.NAMES. What makes each visible:

    stall torque, load friction    the robot's own weight on the ground, going up and going down
    no-load speed                  runs at known duties
    duty per rad, lag              loads and ways of small steps and chirps
    friction at rest, Stribeck     slow ramps of the duty, runs just above it
    viscous friction               coasting: under power the motor's own braking hides it
    armature, play                 turning back and forth, chirps, against the known inertia of the leg
    delay                          all sweeps; the clock measures the time that answers take

Play, sticking and the P law make local minima in the sum of squares. So the fit begins with the sweeps that play hardly
touches; then a grid over play, delay and armature finds where to go on, and tries along ways that the measurements
hardly notice come between the rounds of least squares. Hard turns, where the link bounces, join in last. If that ends
too high, the fit tries the gears' two shares for each other, then another start.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import product
from math import exp, log
from statistics import median
from typing import Any

import numpy as np

from ..robot.actuators import Servo
from .model import NAMES, SAG, STEP_S, Array, Load, Told, friction_Nm, from_file, motor_stall_Nm, simulate
from .sweeping import Trace

SHIFTS = {"backlash_rad": 0.01, "act_s": 0.01}  # these are moved by this unit, the others by their logarithm
LITTLE_PLAY = ("run", "ramp", "slow", "steps", "coast")  # sweeps that play hardly touches
HARD = "hard"  # turns so hard that the link bounces on its flanks: the cost has steps there, and small hollows
BY_P_LAW = ("steps", "chirp", "slow")  # sweeps whose load shows the P law; elsewhere the duty is the commanded one
ROUGH_COUNTS, OFFSET_COUNTS, ROUGH_LOAD, ROUGH_BALANCE = 0.35, 0.1, 0.01, 0.002
ROUGH_SAG = 0.5  # how far the supply's sag may be from the file's, as a logarithm: a factor of 1.6 (chosen)
SIDES = 25  # places within the play at which the rotor may begin: a third of a step of the position from each other
LAID_NM = 0.015  # a weight that presses the play to one side while the joint is held (chosen)
SOFT = 2.0  # a difference beyond this many standard deviations counts only linearly
NUDGE = 0.01  # of differences that replace derivatives: as wide as the local minima
LONGEST = 0.2  # a way that the measurements do not notice is no longer than that: 20 % (chosen)
FAR = (-64, -32, -16, -8, -4, -2, -1, 1, 2, 4, 8, 16, 32, 64)  # times a way: where to try, also behind the next hill
ROUNDS = 8  # of least squares, before it looks around again
FAST_RAD_S = 2.0  # friction at this speed is one of the unknowns, because runs show it well
VALLEYS = 10  # most times that a fit looks around in its valley (chosen)
STILL = 8  # samples without a step of the position, 0.04 s, before and after which a joint stands (chosen)
LEAST_VISCOUS = 0.003  # N m s/rad, below which viscous friction bends to 0 (chosen)
ENOUGH = 0.3  # mean cost at which no other start is tried: noise alone explains 0.26 .. 0.31 with emulated joints
GOOD = 0.36  # mean cost of a fit that can be trusted (chosen)
STARTS = (
    {"backlash_rad": 0.018, "viscous_Nms_rad": 0.02}, {"load_motor": 0.14, "load_external": 0.2, "backlash_rad": 0.02},
    {"load_motor": 0.28, "stribeck_rad_s": 0.35, "viscous_Nms_rad": 0.025},
)  # fmt: skip


@dataclass(frozen=True)
class Ground:
    """A joint's samples under the robot's weight while it turned: speeds, loads on the shaft, duties of 12 V."""

    speed_rad_s: Array
    load_Nm: Array
    duty: Array


@dataclass
class Fitted:
    """A joint's numbers, each one's uncertainty by the fit itself, and how well they explain the measurements."""

    values: dict[str, float]
    spread: dict[str, float] = field(default_factory=dict)
    misfit: float = 0.0
    answer_s: float = 0.0
    fits: bool = True

    @property
    def delay_s(self) -> float:
        """From sending a goal until it acts, and from measuring until known."""
        return self.values["act_s"] + self.answer_s


class JointFit:
    """One joint's fit: its sweeps, its load in the air, and its samples on the ground if there are any."""

    def __init__(self, servo: Servo, load: Load, traces: Sequence[Trace], ground: Ground | None = None) -> None:
        self.servo, self.load, self.ground = servo, load, ground
        self.traces = [trace for trace in traces if len(trace.position_rad) > 10]
        self._moves = {trace.name: moves(trace) for trace in self.traces}
        self.base = from_file(servo)
        self._free = [*NAMES, *[SAG] * (self.base[SAG] > 0)]
        self.told, self._columns = told_of(self.traces, servo, load), list(range(len(self.traces)))
        self._rest = self.base["coulomb_Nm"] + self.base["stribeck_Nm"]
        self._fast = self.base["coulomb_Nm"] + FAST_RAD_S * self.base["viscous_Nms_rad"]

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to another process as what it was made of: a third of the bytes."""
        return JointFit, (self.servo, self.load, self.traces, self.ground)

    def run(self) -> Fitted:
        """Return the numbers; the best of a few starts."""
        best, least = np.zeros(len(self._free)), float("inf")
        for start in STARTS:
            x, cost = self._descend(self._of({**self.base, **start}))
            if cost >= ENOUGH * self._size:
                x, cost = min((x, cost), self._down_the_valley(self._swapped(x)), key=lambda end: end[1])
            if cost < least:
                best, least = x, cost
            if least < ENOUGH * self._size:
                break
        values = self._numbers(best)
        answers = [b - a for trace in self.traces for a, b in zip(trace.asked_s, trace.answered_s, strict=True)]
        misfit = least / self._size
        return Fitted(values, self._spread(best), misfit, median(answers), misfit < GOOD)

    def _swapped(self, x: Array) -> Array:
        """Return unknowns with the gears' two shares for each other.

        Gears pass on |load_external x load - load_motor x motor|: there is a hollow with either as the greater one.
        """
        values = self._numbers(x)
        return self._of({**values, "load_motor": values["load_external"], "load_external": values["load_motor"]})

    def _numbers(self, x: Array) -> dict[str, float]:
        return {name: float(value[0, 0]) for name, value in self._values(x[None]).items()}

    def _descend(self, x: Array) -> tuple[Array, float]:
        """Return the best unknowns from a start, and their cost: little play first, hard turns last."""
        self._settle(x)
        with self._only(lambda kind: kind in LITTLE_PLAY):
            x, _ = self._squares(x)
        with self._only(lambda kind: kind != HARD):
            x, _ = self._from_grid(x, 0.016, 0.006, (0.7, 0.85, 1.0, 1.2, 1.4))
            x, _ = self._from_grid(x, 0.006, 0.002, (0.95, 1.0, 1.05))
            x, _ = self._down_the_valley(x)
        x, _ = self._from_grid(x, 0.003, 0.0005, (0.98, 1.0, 1.02))
        return self._down_the_valley(x)

    @contextmanager
    def _only(self, wanted: Callable[[str], bool]) -> Iterator[None]:
        """Look at some kinds of sweeps for a while."""
        everything = self._columns
        self._columns = [at for at, trace in enumerate(self.traces) if wanted(kind_of(trace))]
        try:
            yield
        finally:
            self._columns = everything

    def _from_grid(self, x: Array, play: float, late: float, heavier: Sequence[float]) -> tuple[Array, float]:
        """Start again from the best of a grid: so much more and less play and delay, times so much armature."""
        self._settle(x)
        at_play, at_late, at_rotor = (self._free.index(name) for name in ("backlash_rad", "act_s", "armature_kg_m2"))
        least = 0.02 - self.base["backlash_rad"] / SHIFTS["backlash_rad"]
        tries = []
        for u, v, w in product(np.linspace(-1, 1, 11), np.linspace(-1, 1, 7), heavier):
            y = x.copy()
            y[at_play] = max(y[at_play] + u * play / SHIFTS["backlash_rad"], least)
            y[at_late] += v * late / SHIFTS["act_s"]
            y[at_rotor] += log(w)
            tries.append(y)
        return self._best_of(np.array(tries))

    def _down_the_valley(self, x: Array) -> tuple[Array, float]:
        for _ in range(VALLEYS):
            self._settle(x)
            before = float(self._costs(x[None])[0])
            ways = self._ways(x)
            tries = np.array([x] + [x + far * way for way in ways for far in FAR])
            found, cost = self._best_of(tries, ways)
            if cost >= before:
                return x, before
            x = found
            if before - cost < 1:
                break
        return x, cost

    def _settle(self, x: Array) -> None:
        self.settle_at(self._values(x[None]))

    def settle_at(self, p: Mapping[str, Array]) -> None:
        """Choose where the rotor begins in each sweep: a weak weight leaves that open, a strong one decides it."""
        sides = np.linspace(-1, 1, SIDES)[:, None] * np.ones(len(self.traces))
        laid = np.abs(self.load.at(self.told.start_rad)) > LAID_NM
        sides[:, laid] = -np.sign(self.load.at(self.told.start_rad[laid]))
        self.told = replace(self.told, side=sides)
        many = {name: np.repeat(value, SIDES, axis=0) for name, value in p.items()}
        with self._only(lambda kind: True):
            costs = [soft(self._off(*seen)) for seen in self.seen(many)]
        best = np.argmin(np.array(costs), axis=1)
        self.told = replace(self.told, side=sides[best, np.arange(len(self.traces))])

    def _best_of(self, tries: Array, ways: Array | None = None) -> tuple[Array, float]:
        """Start again from the best of some tries."""
        return self._squares(tries[int(np.argmin(self._costs(tries)))], ways)

    def _squares(self, x: Array, ways: Array | None = None) -> tuple[Array, float]:
        """Return better unknowns, and their cost: least squares along some ways, or of each unknown by itself."""
        from scipy.optimize import least_squares

        ways, nudge = (np.eye(len(x)), NUDGE) if ways is None else (ways, 1.0)
        found = least_squares(
            lambda far: self.residuals((x + far @ ways)[None])[0], np.zeros(len(ways)),
            lambda far: self._slopes(x + far @ ways, nudge * ways) / nudge, loss="soft_l1", f_scale=SOFT,
            max_nfev=ROUNDS, xtol=1e-4, ftol=1e-5, gtol=1e-8,
        )  # fmt: skip
        return x + found.x @ ways, float(found.cost)

    def _slopes(self, x: Array, ways: Array) -> Array:
        """Return the residuals' slopes along ways, a column for each, all in one simulation."""
        found = self.residuals(np.concatenate([x + ways, x - ways]))
        slopes: Array = ((found[: len(ways)] - found[len(ways) :]) / 2).T
        return slopes

    def _ways(self, x: Array) -> Array:
        """Return independent ways, each as long as the measurements just notice it, if that is not too long.

        The cost is rough: nudges of one size are too long for a steep way, and show nothing of a flat one. So the ways
        that they show are looked at once more.
        """
        ways = NUDGE * np.eye(len(x))
        for _ in range(2):
            _, noticed, turned = np.linalg.svd(self._slopes(x, ways), full_matrices=False)
            ways = turned @ ways / np.maximum(noticed, NUDGE / LONGEST)[:, None]
            ways *= np.minimum(1.0, LONGEST / np.linalg.norm(ways, axis=1))[:, None]
        return ways

    def _costs(self, tries: Array) -> Array:
        return soft(self.residuals(tries))

    @property
    def _size(self) -> int:
        """The number of differences, without those of joints that stand."""
        extra = 0 if self.ground is None else len(self.ground.duty)
        by_p = sum(len(trace.load) for trace in self.traces if by_p_law(trace))
        return int(sum(np.sum(moving) + 1 for moving in self._moves.values())) + by_p + extra

    def _values(self, tries: Array) -> dict[str, Array]:
        """Return numbers from unknowns, a row per try; friction at rest and at speed stand for dry and viscous."""
        p = {name: np.full((len(tries), 1), value) for name, value in self.base.items()}
        for column, name in enumerate(self._free):
            x = tries[:, column : column + 1]
            if name in SHIFTS:
                p[name] = np.maximum(self.base[name] + SHIFTS[name] * x, 1e-5)
            else:
                p[name] = self.base[name] * np.exp(np.clip(x, -4, 3))
        p["load_motor"] = np.minimum(p["load_motor"], 0.8)
        at_rest = self._rest * p["coulomb_Nm"] / self.base["coulomb_Nm"]
        at_speed = self._fast * p["viscous_Nms_rad"] / self.base["viscous_Nms_rad"]
        p["coulomb_Nm"] = np.maximum(at_rest - p["stribeck_Nm"], 1e-4)
        left = p["stribeck_Nm"] * np.exp(-((FAST_RAD_S / p["stribeck_rad_s"]) ** self.servo.friction.stribeck_exponent))
        viscous = (at_speed - p["coulomb_Nm"] - left) / FAST_RAD_S
        p["viscous_Nms_rad"] = (viscous + np.hypot(viscous, LEAST_VISCOUS)) / 2  # never negative, never flat
        return p

    def _of(self, values: Mapping[str, float]) -> Array:
        """Return unknowns from numbers."""
        viscous = values["viscous_Nms_rad"] - LEAST_VISCOUS**2 / values["viscous_Nms_rad"] / 4
        left = values["stribeck_Nm"] * exp(
            -((FAST_RAD_S / values["stribeck_rad_s"]) ** self.servo.friction.stribeck_exponent)
        )
        special = {
            "coulomb_Nm": (values["coulomb_Nm"] + values["stribeck_Nm"]) / self._rest,
            "viscous_Nms_rad": (values["coulomb_Nm"] + FAST_RAD_S * viscous + left) / self._fast,
        }
        return np.array([
            (values[name] - self.base[name]) / SHIFTS[name] if name in SHIFTS
            else log(special.get(name, values[name] / self.base[name]))
            for name in self._free
        ])  # fmt: skip

    def residuals(self, tries: Array) -> Array:
        """Return the differences between model and joint, in units of the noise; a row per try."""
        p = self._values(tries)
        found = [self._off(*seen) for seen in self.seen(p)]
        if self.ground is not None:
            found.append(balance(p, self.servo, self.ground) / ROUGH_BALANCE)
        found.append(tries[:, len(NAMES) :] / ROUGH_SAG)
        return np.concatenate(found, axis=1)

    def _off(self, trace: Trace, places: Array, duties: Array) -> Array:
        """Return one sweep's differences.

        Where the joint began within its step of the position is unknown: its motion tells, as the differences' mean.
        While it stands, its samples are alike, not noise: they only tell that it is within that step.
        """
        off, moves = (places - np.array(trace.position_rad)) / self.servo.step_rad, self._moves[trace.name]
        mean = off @ (moves / max(1, np.sum(moves)))[:, None]
        off = off - mean
        found = [np.where(moves, off, beyond_step(off)) / ROUGH_COUNTS, beyond_step(mean) / OFFSET_COUNTS]
        if by_p_law(trace):
            found.append((duties - np.array(trace.load)) / ROUGH_LOAD)
        return np.concatenate(found, axis=1)

    def seen(self, p: Mapping[str, Array]) -> list[tuple[Trace, Array, Array]]:
        """Return for each sweep the angles and duties that such servos would have reported when the joint was asked."""
        traces, told = [self.traces[column] for column in self._columns], self.told.only(self._columns)
        places, duties, _ = simulate(p, self.servo.friction, self.load, told)
        began = np.broadcast_to(told.start_rad, (1, *places.shape[1:]))
        held = np.broadcast_to(np.array([trace.load[0] for trace in traces]), began.shape)
        places, duties = np.concatenate([began, places]), np.concatenate([held, duties])
        copies, rows = np.arange(places.shape[1])[:, None], []
        for column, trace in enumerate(traces):
            at = np.clip((np.array(trace.asked_s) - p["act_s"]) / STEP_S, 0, len(places) - 2)
            whole = at.astype(int)
            part = at - whole
            rows.append((trace, *(
                values[whole, copies, column] * (1 - part) + values[whole + 1, copies, column] * part
                for values in (places, duties)
            )))  # fmt: skip
        return rows

    def _spread(self, x: Array) -> dict[str, float]:
        """Return the standard deviations from the curvature, as shares; optimistic, because local minima look steep."""
        slopes = self._slopes(x, NUDGE * np.eye(len(x))) / NUDGE
        deviations = np.sqrt(np.maximum(np.diag(np.linalg.pinv(slopes.T @ slopes)), 0.0))
        return {name: float(deviation) for name, deviation in zip(self._free, deviations, strict=True)}


def soft(off: Array) -> Array:
    """Return the cost of each row of differences: half their squares, but large ones count only linearly."""
    costs: Array = SOFT**2 * np.sum(np.sqrt(1 + (off / SOFT) ** 2) - 1, axis=1)
    return costs


def beyond_step(off: Array) -> Array:
    """Return by how much differences, in steps of the position, are more than rounding explains."""
    beyond: Array = off - np.clip(off, -0.5, 0.5)
    return beyond


def moves(trace: Trace) -> Array:
    """Return at which samples a joint moves: its position has just changed, or is about to."""
    steps = np.cumsum(np.diff(trace.position_rad, prepend=trace.position_rad[0]) != 0)
    at = np.arange(len(steps))
    moving: Array = steps[np.minimum(at + STILL, len(at) - 1)] > steps[np.maximum(at - STILL, 0)]
    return moving


def by_p_law(trace: Trace) -> bool:
    """True for a sweep in which the duty follows from the error."""
    return kind_of(trace) in BY_P_LAW


def kind_of(trace: Trace) -> str:
    """Return which kind of sweep it was: the first word of its name."""
    return trace.name.split()[0]


def told_of(traces: Sequence[Trace], servo: Servo, load: Load) -> Told:
    """Return the joint's commands in sweeps, on the model's grid."""
    steps = max(round((trace.sent_s[-1]) / STEP_S) for trace in traces) + 40
    goal, most = np.empty((steps, len(traces))), np.empty((steps, len(traces)))
    for column, trace in enumerate(traces):
        row = np.searchsorted(np.array(trace.sent_s), np.arange(steps) * STEP_S + STEP_S / 2, side="right") - 1
        row = np.clip(row, 0, len(trace.sent_s) - 1)
        goal[:, column], most[:, column] = np.array(trace.goal_rad)[row], np.array(trace.most)[row]
    # Every sweep begins at rest, where a joint takes hardly any current; the mean smooths the steps of 0.1 V.
    volts = np.full(len(traces), np.mean([trace.voltage_V[0] for trace in traces]) / servo.nominal_voltage_V)
    start = np.array([trace.position_rad[0] for trace in traces])
    return Told(goal, most, volts, start, -np.sign(load.at(start)))


def balance(p: Mapping[str, Array], servo: Servo, ground: Ground) -> Array:
    """Return the share of the stall torque by which motor, load and friction do not cancel in a slow turn."""
    stall = motor_stall_Nm(p, servo.friction)
    motor = stall * (ground.duty - ground.speed_rad_s / p["no_load_rad_s"])
    load = np.broadcast_to(ground.load_Nm, motor.shape)
    friction = friction_Nm(p, servo.friction, motor, load, np.abs(ground.speed_rad_s))
    left: Array = (motor + load - np.sign(ground.speed_rad_s) * friction) / stall
    return left
