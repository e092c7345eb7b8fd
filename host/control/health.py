"""Verdicts on a robot from its status (telemetry.py): loop, bus, sensor, battery, heat, versions."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees
from typing import Any

from ..bus.base import JOINT_LABELS, JOINTS
from ..util.version import software_version

OK, NOTE, BAD = "ok", "note", "bad"
MISSED_BAD = 0.01  # of the ticks: more disturbs the walk (chosen)
ERRORS_NOTE, ERRORS_BAD = 0.001, 0.01  # of the requested answers (chosen)
SLOW_LOOP = 0.95  # of its rate
NEAR_LOW, NEAR_HOT_C = 1.05, 10.0  # of the lowest supply; below the highest heat (chosen)
WORST_JOINTS = 3  # so many are named

Status = Mapping[str, Any]


@dataclass(frozen=True)
class Finding:
    """One line: the part, ``ok``, ``note`` or ``bad``, and what was found."""

    name: str
    verdict: str
    found: str


def findings(about: Status, first: Status, last: Status) -> Iterator[Finding]:
    """Yield a line for each part, from the constant data and from two statuses some time apart."""
    yield _state(about, last)
    yield _loop(first, last)
    yield _deadlines(last)
    yield _bus(first, last)
    yield _imu(last)
    yield _battery(about, last)
    yield _heat(about, last)
    yield version_finding(about["versions"])


def _state(about: Status, last: Status) -> Finding:
    name = f"{about['robot']}{', simulated' if about['simulated'] else ''}: {last['state']}"
    if last["stop"] is not None:
        return Finding("robot", NOTE, f"{name}; emergency stop by {last['stop']}")
    return Finding("robot", BAD if last["fault"] else OK, f"{name}; {last['fault']}" if last["fault"] else name)


def _loop(first: Status, last: Status) -> Finding:
    seconds = last["time_s"] - first["time_s"]
    ticks = last["timing"]["ticks"] - first["timing"]["ticks"]
    rate_hz = ticks / seconds if seconds > 0 else 0.0
    wanted_hz = last["timing"]["rate_hz"]
    verdict = OK if rate_hz >= SLOW_LOOP * wanted_hz else BAD
    return Finding("loop", verdict, f"{rate_hz:.1f} of {wanted_hz} Hz in the last {seconds:.1f} s")


def _deadlines(last: Status) -> Finding:
    ticks, missed = last["timing"]["ticks"], last["timing"]["missed"]
    share = missed / max(1, ticks + missed)
    verdict = BAD if share > MISSED_BAD else NOTE if missed else OK
    return Finding("deadlines", verdict, f"{missed} missed of {ticks + missed} ticks")


def _bus(first: Status, last: Status) -> Finding:
    """Count all errors since the drive began, but none from looking for joints before its first tick."""
    nothing: Status = {"bus_asked": 0, "bus_errors": 0, "lost_by_joint": [0] * JOINTS}
    before = nothing if first["timing"]["ticks"] else first
    asked, errors = (max(0, last[key] - before[key]) for key in ("bus_asked", "bus_errors"))
    counts = zip(last["lost_by_joint"], before["lost_by_joint"], strict=True)
    lost = [max(0, late - early) for late, early in counts]  # less than before: what was lost came late after all
    silent = [JOINT_LABELS[joint] for joint in last["silent"]]
    if silent:
        return Finding("bus", BAD, f"no answer from {', '.join(silent)}: check the cable and the power")
    worst = sorted((joint for joint in range(len(lost)) if lost[joint]), key=lambda joint: -lost[joint])
    named = ", ".join(f"{JOINT_LABELS[joint]} {lost[joint]}" for joint in worst[:WORST_JOINTS])
    more = f", {len(worst) - WORST_JOINTS} joints fewer" if len(worst) > WORST_JOINTS else ""
    share = errors / max(1, asked)
    verdict = BAD if share > ERRORS_BAD or not asked else NOTE if share > ERRORS_NOTE else OK
    return Finding("bus", verdict, f"{errors} errors in {asked} answers{f': {named}{more}' if named else ''}")


def _imu(last: Status) -> Finding:
    missed = f"; {last['readings_missed']} readings missed" if last["readings_missed"] else ""
    if last["attitude_rad"] is None:
        return Finding("IMU", BAD, (last["attitude_note"] or "no attitude: the body is not kept level") + missed)
    roll, pitch = (degrees(angle) for angle in last["attitude_rad"])
    note = last["attitude_note"]
    words = f"roll {roll:.1f}, pitch {pitch:.1f} deg{f'; {note}' if note else ''}"
    return Finding("IMU", NOTE if missed or note else OK, words + missed)


def _battery(about: Status, last: Status) -> Finding:
    volts, low_V = last["battery_V"], about["low_V"]
    if volts is None:
        return Finding("battery", BAD, "no joint reports a voltage")
    verdict = BAD if volts < low_V else NOTE if volts < NEAR_LOW * low_V else OK
    return Finding("battery", verdict, f"{volts:.1f} V; the robot sits down below {low_V:.1f}")


def _heat(about: Status, last: Status) -> Finding:
    known = [(heat_C, JOINT_LABELS[joint]) for joint, heat_C in enumerate(last["temperature_C"]) if heat_C is not None]
    hot_C = about["hot_C"]
    if not known:
        return Finding("heat", BAD, "no joint reports a temperature")
    heat_C, joint = max(known)
    if hot_C is None:
        return Finding("heat", OK, f"hottest {joint}: {heat_C:.0f} degrees C")
    verdict = BAD if heat_C > hot_C else NOTE if heat_C > hot_C - NEAR_HOT_C else OK
    return Finding("heat", verdict, f"hottest {joint}: {heat_C:.0f} degrees C; the robot sits down above {hot_C:.0f}")


def version_finding(told: Mapping[str, str]) -> Finding:
    """Return the line with the versions that a drive reports (util/version.py, and its joints')."""
    words = f"caramelo {told['caramelo']}, Python {told['python']}, core: {told['core']}"
    words += f", joints' firmware {told['joints']}" if told["joints"] else ""
    if "," in told["joints"]:
        return Finding("versions", NOTE, f"{words}: the joints differ: give all the same firmware")
    if told["caramelo"] != software_version():
        return Finding("versions", NOTE, f"{words}; this command is {software_version()}: restart the service")
    return Finding("versions", OK, words)
