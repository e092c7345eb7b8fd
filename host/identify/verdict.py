"""Says in words how a joint compares with the robot's other joints, whose servos are of the same type."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from statistics import median

import numpy as np

from ..bus.base import JOINT_LABELS
from ..robot.actuators import Servo
from .fit import Fitted, kind_of
from .model import Array, Load, friction_Nm, motor_stall_Nm
from .sweeping import Trace

APART = 0.25  # a number that differs this much from the others' median is reported (chosen)
PLAIN_BETTER = 1.25  # how much better another weight must explain the sweeps for the joint to count as broken (chosen)
AWAY_RAD, TURNS_RAD_S, LEAST_TURNING = 0.05, 0.2, 100  # play is taken up, friction no longer that at rest (chosen)
STICKS = 1.4  # friction at one place, times the usual one: sound joints show up to 1.1, sticking ones from 1.6 (seen)
BIN_RAD, LEAST_SEEN = 0.04, 3  # places, and runs that must have seen one (chosen)
SOUND, LOOSE, REVERSED, STICKING, BLOCKED, STIFF = "sound", "loose horn", "reversed", "sticking", "blocked", "friction"
UNSAFE = (LOOSE, REVERSED, BLOCKED)  # with these the robot must not stand up
TOLD = {
    "at_rest_Nm": "friction", "stall_Nm": "torque", "no_load_rad_s": "no-load speed", "backlash_deg": "play",
    "duty_per_rad": "stiffness",
}  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """The verdict on one joint; ``kind`` is one of the words above."""

    joint: int
    kind: str
    sentence: str


def weight_is(servo: Servo, load: Load, traces: Sequence[Trace], mirror_rad: float) -> str:
    """Return whether a joint feels its leg's weight (sound), none (loose horn), or its mirror image (reversed).

    The duty of a run goes into speed, friction, acceleration and weight. The weights are known, and the torque by the
    robot file; a linear fit of the rest shows which of the weights leaves least of the duty unexplained.
    """
    runs = [_turning(servo, trace) for trace in traces if kind_of(trace) == "run"]
    at, speed, speeding, duty = (np.concatenate(columns) for columns in zip(*runs, strict=True))
    if len(at) < LEAST_TURNING:
        return SOUND  # it hardly turns: its fit will tell
    way = np.sign(speed)
    fades = np.exp(-np.abs(speed) / servo.friction.stribeck_rad_s)
    rest = np.column_stack([speed, way, way * fades, speeding])
    costs = {}
    for kind, other in ((SOUND, load), (LOOSE, load.gone()), (REVERSED, load.mirrored(mirror_rad * load.ratio))):
        driving = duty + other.at(at) / servo.nominal.stall_Nm
        costs[kind] = float(np.sum((driving - rest @ np.linalg.lstsq(rest, driving, rcond=None)[0]) ** 2))
    best = min(costs, key=lambda kind: costs[kind])
    return best if costs[SOUND] > PLAIN_BETTER * costs[best] else SOUND


def _turning(servo: Servo, trace: Trace) -> tuple[Array, Array, Array, Array]:
    """Return angles, speeds, accelerations and duties of 12 V where a run's joint turns at its limit of the duty."""
    at, speed, speeding, duty = _motion(servo, trace)
    most = np.array(trace.most)
    far = np.abs(np.array(trace.goal_rad) - at) * servo.duty_per_rad > most * 1.5  # it does not brake yet
    use = far & (np.abs(at - at[0]) > AWAY_RAD) & (np.abs(speed) > TURNS_RAD_S) & (np.arange(len(at)) < len(at) - 8)
    return at[use], speed[use], speeding[use], duty[use]


def _motion(servo: Servo, trace: Trace) -> tuple[Array, Array, Array, Array]:
    """Return a sweep's angles, speeds, accelerations, and duties of the nominal voltage."""
    times, at = np.array(trace.asked_s), np.array(trace.position_rad)
    speed = np.gradient(np.convolve(at, np.ones(7) / 7, mode="same"), times)
    speeding = np.gradient(np.convolve(speed, np.ones(5) / 5, mode="same"), times)
    return at, speed, speeding, np.array(trace.load) * np.array(trace.voltage_V) / servo.nominal_voltage_V


def sticking(servo: Servo, load: Load, traces: Sequence[Trace], values: Mapping[str, float]) -> tuple[float, float]:
    """Return how many times the usual friction a joint has at its worst place, and where, rad at the shaft.

    The usual friction is that of ``values``, the other joints' numbers. This joint's torque and speed differ a little,
    which looks like friction that changes with the duty: so a place is compared with the rest of the same run. A joint
    that stands still although it is pushed has at least the friction of the push. 1.0 where too few runs saw any place.
    """
    beyond: dict[int, list[float]] = {}
    runs = (_by_place(*_resistance(servo, load, trace, values)) for trace in traces if kind_of(trace) == "run")
    for run in filter(None, runs):
        usual = median(run.values())
        for place, ratio in run.items():
            beyond.setdefault(place, []).append(ratio - usual)
    found = {place: median(seen) for place, seen in beyond.items() if len(seen) >= LEAST_SEEN}
    worst = max(found, key=lambda place: found[place], default=0)
    return 1.0 + found.get(worst, 0.0), worst * BIN_RAD


def _by_place(at: Array, ratio: Array) -> dict[int, float]:
    """Return the median at each place of a run."""
    places = np.round(at / BIN_RAD).astype(int)
    return {int(place): float(np.median(ratio[places == place])) for place in np.unique(places)}


def _resistance(servo: Servo, load: Load, trace: Trace, values: Mapping[str, float]) -> tuple[Array, Array]:
    """Return the joint's angles along a run, and its friction there as a share of the expected friction."""
    p = {name: np.array([value]) for name, value in values.items()}
    times = np.array(trace.asked_s)
    at, speed, speeding, duty = _motion(servo, trace)
    motor = motor_stall_Nm(p, servo.friction) * (duty - speed / p["no_load_rad_s"])
    weight = load.at(at)
    drives = motor + weight - (p["armature_kg_m2"] + load.inertia_kg_m2) * speeding
    expected = friction_Nm(p, servo.friction, motor, weight, np.abs(speed))
    settled = (times > values["act_s"] + 0.06) & (np.arange(len(at)) < len(at) - 8)
    far = np.abs(np.array(trace.goal_rad) - at) * values["duty_per_rad"] > np.array(trace.most) * 1.1
    use = settled & far & (np.abs(speeding) < 4.0)
    return at[use], (np.abs(drives) / expected)[use]


def told_of(values: Mapping[str, float]) -> dict[str, float]:
    """Return the numbers by which joints are compared."""
    return {
        **values, "at_rest_Nm": values["coulomb_Nm"] + values["stribeck_Nm"],
        "backlash_deg": degrees(values["backlash_rad"]),
    }  # fmt: skip


def brothers(fits: Mapping[int, Fitted], joint: int) -> dict[str, float]:
    """Return the medians of all other joints' numbers; the joint's own if there are no others."""
    return with_middle({at: fit for at, fit in fits.items() if at != joint} or fits).values


def judge(joint: int, fits: Mapping[int, Fitted], stick: tuple[float, float]) -> Verdict:
    """Return the verdict on a joint whose weight is right."""
    label, own, others = JOINT_LABELS[joint], told_of(fits[joint].values), told_of(brothers(fits, joint))
    if stick[0] > STICKS:
        where = f"{degrees(stick[1]):.0f} deg of its servo"
        return Verdict(joint, STICKING, f"{label}: sticks at {where}, with {stick[0]:.1f} times the usual friction: "
                                        "look for a damaged gear, or something that rubs")  # fmt: skip
    apart = {name: own[name] / others[name] - 1 for name in TOLD if others[name] > 0}
    said = [f"{abs(100 * share):.0f} % {'more' if share > 0 else 'less'} {TOLD[name]}"
            for name, share in apart.items() if abs(share) > APART]  # fmt: skip
    if not said:
        sure = "" if fits[joint].fits else "; the fit is poor: look at its picture"
        return Verdict(joint, SOUND, f"{label}: like the other joints{sure}")
    kind = STIFF if apart["at_rest_Nm"] > APART else "apart"
    return Verdict(joint, kind, f"{label}: {', '.join(said)} than the other joints")


def broken(joint: int, kind: str) -> Verdict:
    """Return the verdict on a joint whose weight is wrong."""
    label = JOINT_LABELS[joint]
    why = {
        LOOSE: "does not feel its leg's weight: its horn is loose",
        REVERSED: "feels its leg's weight the wrong way round: its sign in the calibration is reversed",
    }[kind]
    return Verdict(joint, kind, f"{label}: {why}; repair it, calibrate, and measure again")


def with_middle(fits: Mapping[int, Fitted]) -> Fitted:
    """Return a robot's servo: the median of its joints, and how much they differ, as a share."""
    names = next(iter(fits.values())).values
    middle = {name: median(fit.values[name] for fit in fits.values()) for name in names}
    spread = {
        name: float(np.std([fit.values[name] for fit in fits.values()])) / max(abs(middle[name]), 1e-12)
        for name in names
    }
    answer_s = median(fit.answer_s for fit in fits.values())
    return replace(next(iter(fits.values())), values=middle, spread=spread, answer_s=answer_s)
