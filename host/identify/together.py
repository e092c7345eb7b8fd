"""Results from all joints together: loads while the robot stands and sways, the supply while they shake."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..bus.base import JOINTS
from ..bus.dynamixel.table import VOLTS
from ..robot.actuators import Servo
from ..robot.model import Robot
from .carried import joint_per_shaft, on_the_ground_Nm
from .fit import Ground
from .model import NAMES, SAG, STEP_S, Array, Load, Told, side_by_side, simulate
from .sweeping import Stance

WINDOW = 8  # ticks over which means and speeds are taken: a Fibonacci number spreads the phases of the ticks best
SLOW_RAD_S = 0.03  # below this a joint may stick
AROUND = 2  # ms by which the model's turns may be early or late; 1 and 3 give about the same (chosen)
LEAST_NOISE = 0.05  # of a step of the voltage: with less the likelihood has small hollows (chosen)
STRAY = 1e-3  # the likelihood of a reading that nothing explains (chosen)
KEEP = 400  # samples of a joint on the ground: more do not help, because they are not independent


def grounds(robot: Robot, servo: Servo, rows: Sequence[Stance]) -> list[Ground] | None:
    """Return each joint's samples on the ground; None if there are none."""
    rows = [row for row in rows if row.what == "ground"]
    if len(rows) < 10 * WINDOW:
        return None
    times = np.array([row.at_s for row in rows])
    places, duties = np.array([row.position_rad for row in rows]), np.array([row.load for row in rows])
    volts = np.array([np.median(row.voltage_V) for row in rows])[:, None] / servo.nominal_voltage_V
    over = WINDOW - 1
    speeds = (places[over:] - places[:-over]) / (times[over:] - times[:-over])[:, None]
    ratios = [joint_per_shaft(robot, joint) for joint in range(JOINTS)]
    loads = np.array([on_the_ground_Nm(robot, row * ratios) for row in _smooth(places)])
    duty = _smooth(duties * volts)
    return [_ground(speeds[:, joint], loads[:, joint], duty[:, joint]) for joint in range(JOINTS)]


def _smooth(values: Array) -> Array:
    """Return means over the window: the position's steps are 0.75 % of duty each."""
    return np.mean([values[k : len(values) - WINDOW + 1 + k] for k in range(WINDOW)], axis=0)


def _ground(speed: Array, load: Array, duty: Array) -> Ground:
    turning = np.flatnonzero((np.abs(speed) > SLOW_RAD_S) & _steady(speed))
    turning = turning[:: max(1, len(turning) // KEEP)]
    return Ground(speed[turning], load[turning], duty[turning])


def _steady(speed: Array) -> Array:
    """Return where a joint has turned one way for a while, so that its play is taken up and it does not accelerate."""
    ahead, behind = np.roll(speed, -WINDOW), np.roll(speed, WINDOW)
    steady: Array = (speed * ahead > 0) & (speed * behind > 0)
    steady[:WINDOW] = steady[-WINDOW:] = False
    return steady


def supply_ohm(
    servo: Servo, loads: Sequence[Load], numbers: Sequence[Mapping[str, float]], rows: Sequence[Stance]
) -> float | None:
    """Return the supply's resistance from shaking, for the stall current of the robot file; None without either.

    ``loads`` and ``numbers`` (by model.NAMES) are each joint's. The servos do not measure their current, so shaking
    measures the resistance times the stall current. Each servo's readings tell a resistance; the median counts.
    """
    rows = [row for row in rows if row.what == "shake"]
    if servo.stall_A == 0 or len(rows) < 30:
        return None
    volts = np.array([row.voltage_V for row in rows])
    load = side_by_side(loads)
    told = _told(load, rows, float(np.mean(volts)) / servo.nominal_voltage_V)
    current_A = servo.stall_A * _drawn(servo, load, numbers, told, rows)
    return float(np.median([_sag_ohm(current_A, volts[:, joint]) for joint in range(JOINTS)]))


def _told(load: Load, rows: Sequence[Stance], volts: float) -> Told:
    """Return the shaking on the model's grid, a column per joint; ``volts`` is the mean share of the nominal supply."""
    sent = np.array([row.sent_s for row in rows]) - rows[0].sent_s
    grid = np.arange(round((rows[-1].at_s - rows[0].sent_s) / STEP_S) + 1)
    row = np.searchsorted(sent, (grid + 0.5) * STEP_S, side="right") - 1
    goal = np.array([row.goal_rad for row in rows])[row]
    most = np.repeat(np.array([row.most for row in rows])[row][:, None], JOINTS, axis=1)
    start = np.array(rows[0].position_rad)
    return Told(goal, most, np.full(JOINTS, volts), start, -np.sign(load.at(start)))


def _drawn(
    servo: Servo, load: Load, numbers: Sequence[Mapping[str, float]], told: Told, rows: Sequence[Stance]
) -> Array:
    """Return the current of all joints in stall currents of one, as the model shakes: moments around a row x rows.

    It is duty x (duty - rotor's speed / no-load speed), and readings do not show the rotor's speed: at each turn it
    crosses the play while the link goes on, and a few readings later it turns again.
    """
    p = {name: np.array([[each[name] for each in numbers]]) for name in NAMES} | {SAG: np.zeros((1, JOINTS))}
    _, _, drawn = simulate(p, servo.friction, load, told)
    asked = np.array([row.at_s for row in rows])[:, None] - rows[0].sent_s
    at = np.round((asked - p["act_s"]) / STEP_S).astype(int) - 1 + np.arange(-AROUND, AROUND + 1)[:, None, None]
    return np.sum(drawn[np.clip(at, 0, len(drawn) - 1), 0, np.arange(JOINTS)], axis=2)


def _sag_ohm(current_A: Array, volts: Array) -> float:
    """Return the resistance that makes the readings likeliest: a voltage with normal noise, read in steps.

    Each reading is from any of its moments, the rows of ``current_A``. A sag of one or two steps has no slope that
    least squares would find: most readings are the same.
    """
    from scipy.optimize import minimize
    from scipy.special import ndtr

    steps = volts / VOLTS

    def unlikely(x: Array) -> float:
        idle, sag, noise = x[0], x[1], np.hypot(np.exp(x[2]), LEAST_NOISE)
        off = steps - (idle - sag * current_A)
        shares = np.mean(ndtr((off + 0.5) / noise) - ndtr((off - 0.5) / noise), axis=0)
        return -float(np.sum(np.log(np.maximum(shares, STRAY))))

    sag, idle = np.polyfit(np.mean(current_A, axis=0), steps, 1)
    found = minimize(unlikely, [idle, -sag, np.log(0.3)], method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-2})
    return max(0.0, float(found.x[1])) * VOLTS
