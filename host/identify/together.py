"""Results from all joints together: loads while the robot stands and sways, the supply while they shake."""

from collections.abc import Sequence

import numpy as np

from ..bus.base import JOINTS
from ..bus.dynamixel.table import VOLTS
from ..robot.actuators import Servo
from ..robot.model import Robot
from .carried import joint_per_shaft, on_the_ground_Nm
from .fit import Ground
from .model import Array
from .sweeping import Stance

WINDOW = 8  # ticks over which means and speeds are taken: a Fibonacci number spreads the phases of the ticks best
SLOW_RAD_S = 0.03  # below this a joint may stick
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


def supply_ohm(servo: Servo, no_load_rad_s: Sequence[float], rows: Sequence[Stance]) -> float | None:
    """Return the supply's resistance from shaking, for the stall current of the robot file; None without either.

    ``no_load_rad_s``: of each joint. The servos do not measure their current: it is stall current x duty x
    (duty - speed / no-load speed), so shaking measures the resistance times that current. Each servo's readings tell a
    resistance; the median counts.
    """
    rows = [row for row in rows if row.what == "shake"]
    if servo.stall_A == 0 or len(rows) < 30:
        return None
    times, duty = np.array([row.at_s for row in rows]), np.array([row.load for row in rows])
    volts = np.array([row.voltage_V for row in rows])
    speed = np.gradient(np.array([row.position_rad for row in rows]), times, axis=0)
    share = duty * (duty * volts / servo.nominal_voltage_V - speed / np.asarray(no_load_rad_s))
    current_A = servo.stall_A * np.sum(share, axis=1)
    return float(np.median([_sag_ohm(current_A, volts[:, joint]) for joint in range(JOINTS)]))


def _sag_ohm(current_A: Array, volts: Array) -> float:
    """Return the resistance that makes the readings likeliest: a voltage with normal noise, read in steps.

    A sag of one or two steps has no slope that least squares would find: most readings are the same.
    """
    from scipy.optimize import minimize
    from scipy.special import ndtr

    steps = volts / VOLTS

    def unlikely(x: Array) -> float:
        idle, sag, noise = x[0], x[1], np.exp(x[2])
        off = steps - (idle - sag * current_A)
        shares = ndtr((off + 0.5) / noise) - ndtr((off - 0.5) / noise)
        return -float(np.sum(np.log(np.maximum(shares, 1e-9))))

    sag, idle = np.polyfit(current_A, steps, 1)
    found = minimize(unlikely, [idle, -sag, np.log(0.3)], method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-2})
    return max(0.0, float(found.x[1])) * VOLTS
