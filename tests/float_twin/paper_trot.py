"""Paper A's own walk in plain floats: discontinuous trot, cycloid swing with its re-timing, balance optional.

Four phases of T = 0.5 s at 50 Hz: the body moves half a stride, FR + RL swing, the body moves half a stride,
FL + RR swing. Body moves and swings are both cycloids, eqs 11-14; stride = speed x 4 T. Legs FR, FL, RR, RL;
x forward, z up, angles about +y. The hips stay at 0: this is the robot's sagittal plane.
"""

import math

from . import leg as twin_leg
from . import swing

PERIOD_S = 0.5
RATE_HZ = 50
POINTS = 25
DIAGONALS = ((0, 3), (1, 2))
BODY, SWING = 0, 1


def sample_times(p_t, p_n):
    """Return the N instants at which a swing of T is sampled, one sent every 20 ms."""
    return [PERIOD_S * share for share in swing.instants(POINTS, p_t, p_n)]


def cycloid(share):
    """Return (advance 0..1, height 0..1) of eqs 11-14 at t / T = share."""
    return swing.advance(share), swing.lift(share)


def inverse(x_m, z_m, thigh_m, calf_m):
    """Return (thigh, calf) in rad that put the foot at (x, z) from the hip, eqs 1-6 in the plane."""
    return twin_leg.inverse((x_m, 0.0, z_m), 0.0, thigh_m, calf_m, -1)[1:]


class Balance:
    """The paper's pitch controller: PID to 0, integral term and output limited; output is a body pitch in rad."""

    def __init__(self, kp=0.3, ki=7.5, kd=0.006, integral_limit=0.30, output_limit=0.45):
        self.gains = kp, ki, kd
        self.limits = integral_limit, output_limit
        self.integral = 0.0

    def tick(self, pitch_rad, rate_rad_s, dt_s):
        kp, ki, kd = self.gains
        bound, most = self.limits
        self.integral = max(-bound, min(bound, self.integral - ki * pitch_rad * dt_s))
        return max(-most, min(most, self.integral - kp * pitch_rad - kd * rate_rad_s))


class PaperTrot:
    """A controller for the plane: twelve joint goals a tick, sensing only pitch and only if it balances."""

    rate_hz = RATE_HZ

    def __init__(self, robot, speed_m_s=0.05, height_m=0.05, p_t=0.66, p_n=0.33, stand_m=0.170, balance=None):
        self.lengths = robot.thigh_length_m, robot.calf_length_m
        self.hip_x_m = robot.hip_x_m
        self.stride_m = speed_m_s * 4 * PERIOD_S
        self.height_m, self.stand_m, self.balance = height_m, stand_m, balance
        self.times = sample_times(p_t, p_n)
        self.even = sample_times(1, 1)
        self.tick_count = 0
        self.foot_x = [0.0] * 4
        self.from_x = [0.0] * 4

    def tick(self, sensed):
        point, phase = self.tick_count % POINTS, self.tick_count // POINTS % 4
        if point == 0:
            self.from_x = list(self.foot_x)
        lift = self._swing(phase // 2, point) if phase % 2 == SWING else self._body(point)
        self.tick_count += 1
        pitch = 0.0
        if self.balance:
            pitch = self.balance.tick(sensed.pitch_rad, sensed.pitch_rate_rad_s, 1 / RATE_HZ)
        goals = []
        for leg in range(4):
            goals += [0.0] + list(self._leg(leg, lift[leg], pitch))
        return goals

    def _body(self, point):
        """All feet go back half a stride under the body."""
        share = swing.advance(self.even[point] / PERIOD_S)
        self.foot_x = [x - share * self.stride_m / 2 for x in self.from_x]
        return [0.0] * 4

    def _swing(self, pair, point):
        """One diagonal goes forward to half a stride ahead of its hips' middle; the other stands."""
        share, rise = cycloid(self.times[point] / PERIOD_S)
        lift = [0.0] * 4
        for leg in DIAGONALS[pair]:
            self.foot_x[leg] = self.from_x[leg] + share * (self.stride_m / 2 - self.from_x[leg])
            lift[leg] = self.height_m * rise
        return lift

    def _leg(self, leg, lift_m, pitch_rad):
        """Joint angles for a foot of the level frame when the body is pitched by ``pitch_rad`` (eqs 7-10)."""
        x, z = self.hip_x_m[leg] + self.foot_x[leg], -self.stand_m + lift_m
        cos, sin = math.cos(pitch_rad), math.sin(pitch_rad)
        in_body_x, in_body_z = cos * x - sin * z, sin * x + cos * z
        return inverse(in_body_x - self.hip_x_m[leg], in_body_z, *self.lengths)
