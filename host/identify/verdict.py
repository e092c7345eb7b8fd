"""Says in words how a joint compares with the robot's other joints, whose servos are of the same type."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from statistics import median

import numpy as np

from ..bus.base import JOINT_LABELS
from ..robot.actuators import Servo
from .fit import Fitted, JointFit
from .model import Array, Load, friction_Nm, motor_stall_Nm
from .sweeping import Trace

APART = 0.25  # a number that differs this much from the others' median is reported (chosen)
PLAIN_BETTER = 1.25  # how much better another weight must explain the sweeps for the joint to count as broken (chosen)
STICKS = 1.7  # friction at one place, times the usual friction (chosen)
BIN_RAD, LEAST_SEEN = 0.04, 12
SOUND, LOOSE, REVERSED, STICKING, BLOCKED, STIFF = "sound", "loose horn", "reversed", "sticking", "blocked", "friction"
UNSAFE = (LOOSE, REVERSED, BLOCKED)  # with these the robot must not stand up
TOLD = {
    "at_rest_Nm": ("friction", 1.0), "stall_Nm": ("torque", 1.0), "no_load_rad_s": ("no-load speed", 1.0),
    "backlash_deg": ("play", 1.0), "duty_per_rad": ("stiffness", 1.0),
}  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """The verdict on one joint; ``kind`` is one of the words above."""

    joint: int
    kind: str
    sentence: str


def weight_is(servo: Servo, load: Load, traces: Sequence[Trace], mirror_rad: float) -> str:
    """Return whether a joint feels its leg's weight (sound), none (loose horn), or its mirror image (reversed)."""
    costs = {}
    for kind, other in ((SOUND, load), (LOOSE, load.gone()), (REVERSED, load.mirrored(mirror_rad * load.ratio))):
        costs[kind] = JointFit(servo, other, traces).glance()
    best = min(costs, key=lambda kind: costs[kind])
    return best if costs[SOUND] > PLAIN_BETTER * costs[best] else SOUND


def sticking(servo: Servo, load: Load, traces: Sequence[Trace], values: Mapping[str, float]) -> tuple[float, float]:
    """Return how many times the usual friction a joint has at its worst place, and where, rad at the shaft.

The usual friction is that of ``values``, scaled to the joint's own median. A joint that stands still although it is
pushed has at least the friction of the push.
    """
    places, ratios = [], []
    for trace in traces:
        if trace.name.split()[0] == "run":
            at, ratio = _resistance(servo, load, trace, values)
            places.append(at)
            ratios.append(ratio)
    at, ratio = np.concatenate(places), np.concatenate(ratios)
    cells = np.round(at / BIN_RAD).astype(int)
    found = {int(cell): float(np.median(ratio[cells == cell])) for cell in np.unique(cells)
             if np.sum(cells == cell) >= LEAST_SEEN}  # fmt: skip
    usual = median(found.values())
    worst = max(found, key=lambda cell: found[cell])
    return found[worst] / max(usual, 0.05), worst * BIN_RAD


def _resistance(servo: Servo, load: Load, trace: Trace, values: Mapping[str, float]) -> tuple[Array, Array]:
    """Return the joint's angles along a run, and its friction there as a share of the expected friction."""
    p = {name: np.array([value]) for name, value in values.items()}
    times, at = np.array(trace.asked_s), np.array(trace.position_rad)
    smooth = np.convolve(at, np.ones(7) / 7, mode="same")
    speed = np.gradient(smooth, times)
    speeding = np.gradient(np.convolve(speed, np.ones(5) / 5, mode="same"), times)
    volts = np.array(trace.voltage_V) / servo.nominal_voltage_V
    motor = motor_stall_Nm(p, servo.friction) * (np.array(trace.load) * volts - speed / p["no_load_rad_s"])
    weight = load.at(at)
    drives = motor + weight - (p["armature_kg_m2"] + load.inertia_kg_m2) * speeding
    expected = friction_Nm(p, servo.friction, motor, -weight, np.abs(speed))
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
    others = [fit.values for at, fit in fits.items() if at != joint] or [fits[joint].values]
    return {name: median(values[name] for values in others) for name in others[0]}


def judge(joint: int, fits: Mapping[int, Fitted], stick: tuple[float, float]) -> Verdict:
    """Return the verdict on a joint whose weight is right."""
    label, own, others = JOINT_LABELS[joint], told_of(fits[joint].values), told_of(brothers(fits, joint))
    if stick[0] > STICKS:
        where = f"{degrees(stick[1]):.0f} deg of its servo"
        return Verdict(joint, STICKING, f"{label}: sticks at {where}, with {stick[0]:.1f} times the usual friction: "
                                        "look for a damaged gear, or something that rubs")  # fmt: skip
    apart = {name: own[name] / others[name] - 1 for name in TOLD if others[name] > 0}
    said = [f"{abs(100 * share):.0f} % {'more' if share > 0 else 'less'} {TOLD[name][0]}"
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
    first = replace(next(iter(fits.values())), values=middle, spread=spread)
    first.answer_s = median(fit.answer_s for fit in fits.values())
    return first
