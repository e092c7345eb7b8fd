"""The trot in floating point and SI, one tick at a time: what shared/trot computes in integers.

Feet are in the body's frame (x forward, y left, z up, from the middle of the hips). Legs FR FL RR RL.
"""

import math
from collections import deque
from dataclasses import dataclass, field

from host.robot import trot_tuning as tuning
from host.robot.drives import friction_bands, joint_drives
from sim2d.model import GRAVITY_M_S2 as G
from tests.float_twin import leg as twin_leg

LATER = (0, 1, 1, 0)  # half a cycle later than the diagonal FR RL
TURN_MAX = 16383 / 2**18  # rad a tick


def limit(value, most):
    return max(-most, min(most, value))


def to_level(point, roll, pitch):
    """Turn a small tilt out of a point of the body's frame."""
    x, y, z = point
    y, z = y - z * roll, z + y * roll
    return [x + z * pitch, y, z - x * pitch]


def to_body(point, roll, pitch):
    """Turn a small tilt into a point of the level frame."""
    x, y, z = point
    x, z = x - z * pitch, z + x * pitch
    return [x, y + z * roll, z - y * roll]


def way(share):
    """Return how far a foot on a cycloid is after a share of its time."""
    return share - math.sin(2 * math.pi * share) / (2 * math.pi)


@dataclass
class Senses:
    """What is measured in a tick: 12 joints, roll and pitch, rates about x, y and z; ``known`` if all of them are.

    went: the body's speed by the odometry, m/s, forward and left.
    """

    joints: list = field(default_factory=lambda: [0.0] * 12)
    tilt: tuple = (0.0, 0.0)
    rates: tuple = (0.0, 0.0, 0.0)
    known: bool = True
    went: tuple = (0.0, 0.0)


class FloatTrot:
    """One robot's trot; ``tick`` returns twelve goals."""

    def __init__(self, robot, rate_hz=50):
        self.robot, self.dt = robot, 1 / rate_hz
        self.f = figures = tuning.trot_figures(robot)
        self.h, self.leg_m = figures.height_m, figures.leg_m
        self.rolling = tuning.rolling(robot)
        drives, ratio = joint_drives(robot), robot.calf_drive.ratio
        self.give = [robot.mass_kg * G / drive.stiffness_Nm_rad for drive in drives]
        self.fastest = [math.floor(robot.actuator.fastest_rad_s * k * self.dt * 65536 / math.tau) * math.tau / 65536
                        for k in (1.0, 1.0, ratio)]
        self.friction, self.of_sag = friction_bands(robot)
        self.delay = 1 + math.floor(robot.bus.delay_s * rate_hz + 1e-9)
        self.late, self.push_lag = tuning.LATE_PER_S * robot.bus.delay_s, tuning.HELD_PUSH * figures.gives_m
        self.feet = [list(self.at_hip(leg, robot.foot_m(leg, self.h))) for leg in range(4)]
        self.lift_offs = [list(foot) for foot in self.feet]
        self.phase = tuning.STANCE_SHARE / 2 - 0.25
        self.measured_speed, self.drift, self.foot_speed = [0.0] * 2, [0.0] * 2, [0.0] * 2
        self.heading = self.high_left = self.u = 0.0
        self.slow_swings = 0
        self.pushed = False
        self.hurries_high = tuning.can_lift(robot, figures, tuning.HURRY)
        self.load, self.stance, self.early_contact = [0.0] * 4, [1] * 4, [0] * 4
        self.low, self.high = tuning.LOW_LIFT * self.leg_m, tuning.HIGH_LIFT * self.leg_m
        self.highest = tuning.top_lift_m(robot)
        self.lift, self.apex, self.swing_top = self.low, [self.low] * 4, [0.0] * 4
        self.held_up, self.shortened, self.peak_lag, self.usual_lag = [False] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4
        self.rises_first = [False] * 4
        self.known, self.measured, self.before, self.expected = 0, None, None, None
        self.residual, self.residual_rate = [[0.0, 0.0] for _ in range(4)], [0.0] * 4
        self.past = deque(maxlen=16)  # (feet, stands) of the ticks before
        self.joints, self.slope, self.uneven = None, [0.0, 0.0], 0.0
        self.last_pose, self.moving = [0.0] * 6, False
        self.careful, self.no_care_s = False, 2.0

    # --- one leg

    def at_hip(self, leg, foot):
        x, y = self.robot.hip_m(leg)
        return foot[0] + x, foot[1] + y, foot[2]

    def links(self, leg):
        hip_offset_m, thigh_m, calf_m = self.robot.geometry.links_m
        return hip_offset_m * self.robot.side(leg), thigh_m, calf_m

    def forward(self, leg, q):
        return self.at_hip(leg, twin_leg.forward(q, *self.links(leg)))

    def inverse(self, leg, foot):
        x, y = self.robot.hip_m(leg)
        at = foot[0] - x, foot[1] - y, foot[2]
        return list(twin_leg.inverse(at, *self.links(leg), self.robot.knee_sign(leg)))

    def sag(self, leg, q, foot):
        hip = self.robot.hip_m(leg)
        x, y, knee = foot[0] - hip[0], foot[1] - hip[1], -self.robot.geometry.thigh_m * math.sin(q[1])
        above, below = knee * self.load[leg], (x - knee) * self.load[leg]
        around = -y * self.load[leg] * self.give[0]
        if self.robot.calf_drive.coupled:
            give = above * self.give[1]
            return around, give, below * self.give[2] - give
        return around, (above + below) * self.give[1], below * self.give[2]

    # --- what is felt

    def estimate(self, senses):
        if not senses.known:
            self.known, self.measured_speed = 0, list(self.foot_speed)
            return
        feet = [self.forward(leg, senses.joints[3 * leg : 3 * leg + 3]) for leg in range(4)]
        if self.known:
            self.estimate_speed(feet, [limit(rate * self.dt, TURN_MAX) / self.dt for rate in senses.rates])
        self.before, self.measured = self.measured or feet, feet
        if self.known > self.delay:
            self.update_residual(feet)
        elif self.known == self.delay:
            self.expected = [[foot[0], foot[2]] for foot in self.past[-self.delay][0]]
            for leg in range(4):
                self.residual[leg][0] = feet[leg][0] - self.expected[leg][0]
        self.known = min(100, self.known + 1)

    def estimate_speed(self, feet, rates):
        gx, gy, gz = rates
        long_ago = self.past[-self.delay - 1][1] if len(self.past) > self.delay else [0] * 4
        speeds = []
        for leg in range(4):
            if long_ago[leg] and self.past[-1][1][leg]:
                a, (x, y, z) = self.measured[leg], feet[leg]
                speeds.append((-(x - a[0]) / self.dt - gy * z + gz * y, -(y - a[1]) / self.dt - gz * x + gx * z))
        share = self.dt / (self.dt + self.f.stance_s / 4)
        for i in range(2):
            if speeds:
                mean = sum(speed[i] for speed in speeds) / len(speeds)
                self.measured_speed[i] += share * (mean - self.measured_speed[i])

    def update_residual(self, feet):
        share = self.dt / (self.dt + tuning.UNHINDERED_LAG_SHARE * self.f.lag_s)
        wanted = self.past[-self.delay][0]
        for leg in range(4):
            for i, axis in enumerate((0, 2)):
                self.expected[leg][i] += share * (wanted[leg][axis] - self.expected[leg][i])
                before, self.residual[leg][i] = self.residual[leg][i], feet[leg][axis] - self.expected[leg][i]
                if axis == 0:
                    self.residual_rate[leg] = self.residual[leg][0] - before

    def update_slope(self):
        """Follow the slope of the measured feet that stand: a step of normalized least mean squares."""
        x, y = self.tilt
        feet = [(*foot[:2], foot[2] + foot[1] * x - foot[0] * y) for foot in self.measured]
        feet = [foot for foot, stands in zip(feet, self.stance, strict=True) if stands]
        if len(feet) < 2:
            return
        middle = [sum(foot[i] for foot in feet) / len(feet) for i in range(3)]
        arms = [[p - q for p, q in zip(foot, middle, strict=True)] for foot in feet]
        off = [z - x * self.slope[0] - y * self.slope[1] for x, y, z in arms]
        square = sum(x * x + y * y for x, y, _ in arms)
        share = self.dt / (self.dt + tuning.SLOPE_CYCLES * self.f.cycle_s)
        for i in range(2):
            step = sum(e * arm[i] for e, arm in zip(off, arms, strict=True)) / square
            self.slope[i] = limit(self.slope[i] + share * limit(step, 0.5), 0.3)
        self.uneven += share / 4 * (min(sum(map(abs, off)) / len(off), self.leg_m / 16) - self.uneven)

    def ground_z(self, x, y):
        return x * self.slope[0] + y * self.slope[1]

    # --- what is wanted

    def steer(self, speed, rates, pose, moving, went):
        """Write the speeds of the feet, the turn and the further footholds."""
        self.stance_speed, self.capture = [0.0, 0.0], [0.0, 0.0]
        self.was_pushed, self.pushed = self.pushed, False
        for i in range(2):
            foot = self.foot_speed[i] = speed[i] * self.rolling
            missed = speed[i] - went[i]
            most = 0.3 * abs(speed[i]) + tuning.DRIFT_LEAST_M_S
            if abs(missed) <= most:
                self.drift[i] = limit(self.drift[i] + tuning.DRIFT_SHARE * missed * self.dt / self.f.cycle_s, most)
            if self.high_left or not self.known:
                self.drift[i] = 0.0
            self.stance_speed[i] = foot + self.drift[i]
            self.pushed |= abs(self.measured_speed[i]) - abs(foot) > tuning.PUSHED_FROUDE * math.sqrt(G * self.h)
            self.capture[i] = limit((self.measured_speed[i] - foot) * self.f.capture_s, self.f.capture_most_m)
        self.pushed &= bool(self.was_pushed or not self.high_left or self.hurries_high)
        self.skips = self.pushed and not self.was_pushed and not self.high_left
        if self.high_left:
            rest = sum(place[0] for place in self.f.rests_m) / 4 - pose[0]
            off = sum(foot[0] for foot in self.feet) / 4 - rest
            wait = (off - limit(off, 8 / 1024 * self.leg_m)) * 8 / self.f.cycle_s
            self.stance_speed[0] += 0.0 if wait * self.foot_speed[0] > 0 else wait
            if self.stance_speed[0] * self.foot_speed[0] < 0 and not self.climbs():
                self.stance_speed[0] = 0.0
        turn = speed[2] + (pose[5] - self.last_pose[5]) / self.dt
        if moving:
            self.heading = limit(self.heading + (turn - rates[2]) * self.dt, 0.5)
            turn += self.heading * tuning.HEADING_HZ
        else:
            self.stance_speed, self.drift = [0.0, 0.0], [0.0, 0.0]
        self.turn = limit(turn, TURN_MAX / self.dt)

    def level_body(self, tilt, rates, pose, balance):
        """Write the tilt to come, the turns that level the body or follow its pose; follow that along the ground."""
        ahead_s = min(self.robot.bus.delay_s + self.dt / 2, tuning.LEAD_MOST_S)
        self.then = [tilt[i] + limit(rates[i], TURN_MAX / self.dt) * ahead_s for i in range(2)]
        gain, ahead_s = tuning.LEVEL_SHARE / self.f.tipping_s, 0.0
        if self.careful:
            gain, ahead_s = gain * tuning.CAREFUL_LEVEL, tuning.CAREFUL_LEAD_S
        turns = [-gain * (tilt[i] + limit(rates[i], TURN_MAX / self.dt) * ahead_s - pose[i + 3]) for i in range(2)]
        if not (balance and self.known):
            turns = [(pose[i + 3] - self.last_pose[i + 3]) / self.dt for i in range(2)]
        self.level = [limit(turn, TURN_MAX / self.dt) for turn in turns]
        for i in range(2):
            self.stance_speed[i] += (pose[i] - self.last_pose[i]) / self.dt
        self.rise_speed = (pose[2] - self.last_pose[2]) / self.dt
        self.last_pose = list(pose)

    def choose_lift(self):
        self.lift = tuning.CAREFUL_LIFT * self.leg_m if self.careful else self.low
        if self.high_left:
            self.lift = self.high
            gone = max(0.05, abs(self.measured_speed[0]) + abs(self.measured_speed[1])) * self.dt
            self.high_left = max(0.0, self.high_left - (0.0 if self.climbs() else gone))

    def choose_care(self):
        if not self.known or max(map(abs, self.tilt)) > 1000 / 16384:
            self.no_care_s = 2.0
        self.no_care_s = max(0.0, self.no_care_s - self.dt)
        fastest, steepest = max(map(abs, self.foot_speed)), max(map(abs, self.slope))
        slow = 0 < fastest <= tuning.CAREFUL_FROUDE * math.sqrt(G * self.h) and steepest <= 0.1
        rough = self.uneven > 41 / 16384 * self.leg_m and not self.high_left
        self.careful = slow and rough and self.no_care_s < self.dt / 2

    def climbs(self):
        steep = self.slope[0] * (-1 if self.foot_speed[0] < 0 else 1) > 0.1
        return steep and self.uneven > 98 / 16384 * self.leg_m

    # --- who swings

    def advance_legs(self, moving):
        if not moving:
            self.phase, self.stance, self.early_contact = tuning.STANCE_SHARE / 2 - 0.25, [1] * 4, [0] * 4
            return
        hurries = self.pushed and not all(self.stance)
        pace = tuning.CAREFUL_PACE if all(self.stance) and self.careful else 1.0
        self.phase = (self.phase + (tuning.HURRY if hurries else pace) * self.dt / self.f.cycle_s) % 1.0
        if hurries and self.skips:
            self.phase += max(0.0, 1 - 2 * self.u) * (1 - tuning.STANCE_SHARE)
        for leg in range(4):
            part = (self.phase + 0.5 * LATER[leg]) % 1.0 - tuning.STANCE_SHARE
            if part < 0:
                self.stance[leg] = 1
                self.check_landing(leg, part + tuning.STANCE_SHARE)
                continue
            self.u = part / (1 - tuning.STANCE_SHARE)
            if self.early_contact[leg] == 0:
                if self.stance[leg]:
                    self.lift_offs[leg] = to_level(self.feet[leg], *self.then)
                    self.begin_swing(leg)
                self.stance[leg] = self.react(leg)

    def react(self, leg):
        """Look at one foot in the air; return 1 if it stands from now on."""
        if self.known <= self.delay:
            return 0
        if self.u > 0.5 and self.stands_high(leg, 31 / 1024):
            self.high_left = tuning.HIGH_LENGTHS * self.f.length_m
            self.meet_ground(leg, 0.25)
            return 1
        if self.u > 0.1:
            self.hold_up(leg)
        behind = self.residual[leg][0] / (2 if self.foot_speed[0] else 1)
        self.shortened[leg] = -behind if self.held_up[leg] else 0.0
        return 0

    def stands_high(self, leg, share):
        """Return whether a foot that has come down, and falls no more, is too high by a share of the leg."""
        z = self.measured[leg][2]
        self.swing_top[leg] = max(self.swing_top[leg], z)
        came_down = self.swing_top[leg] - z >= 32 / 1024 * self.leg_m
        falls = self.before[leg][2] - z > self.apex[leg] / 2 / self.f.swing_s * self.dt
        return self.residual[leg][1] > share * self.leg_m and came_down and not falls

    def begin_swing(self, leg):
        self.apex[leg] = self.swing_apex(leg)
        alone = self.apex[leg ^ 1] < self.highest and not self.climbs()
        self.rises_first[leg] = bool(self.held_up[leg] and self.high_left and alone)
        self.count_slow()
        if not self.held_up[leg]:
            self.usual_lag[leg] = min(0.75 * self.usual_lag[leg] + 0.25 * self.peak_lag[leg], 41 / 1024 * self.leg_m)
        self.held_up[leg], self.peak_lag[leg], self.shortened[leg] = False, 0.0, 0.0
        self.swing_top[leg], self.stance[leg] = -math.inf, 0

    def count_slow(self):
        """Swing high after sixteen swings in a row that began at less than half of the commanded speed."""
        back = -1 if self.foot_speed[0] < 0 else 1
        slow = 2 * back * self.measured_speed[0] < abs(self.foot_speed[0]) > 0
        self.slow_swings = self.slow_swings + 1 if slow and not self.high_left else 0
        if self.slow_swings >= 16:
            self.high_left = tuning.HIGH_LENGTHS * self.f.length_m

    def swing_apex(self, leg):
        return self.highest if self.high_left and self.held_up[leg] else self.lift

    def hold_up(self, leg):
        high = self.apex[leg] >= self.high
        back = 1 if self.foot_speed[0] < 0 else -1
        mate_lag = back * self.residual[3 - leg][0]
        behind = back * self.residual[leg][0] - mate_lag
        self.peak_lag[leg] = max(self.peak_lag[leg], behind)
        usual = self.usual_lag[leg] + 2 * abs(self.f.rests_m[0][1]) * tuning.TURN_LATE_S * abs(self.turn)
        behind -= usual
        most = 61 / 1024 * self.leg_m if high else self.most_behind(leg, mate_lag, usual)
        if behind > most or (not high and self.strikes(leg, behind)):
            self.held_up[leg] = True
            if self.apex[leg] < self.highest:
                self.high_left = tuning.HIGH_LENGTHS * self.f.length_m
            if not high:
                self.apex[leg] = self.high

    def most_behind(self, leg, mate_lag, usual):
        most = (26 if self.u > 0.4 else 61) / 1024 * self.leg_m + max(0.0, mate_lag) / 4
        most = min(most, self.push_lag)
        return most + (self.late * (most + usual) if self.may_be_late(leg) else 0.0)

    def strikes(self, leg, behind):
        if self.push_lag > 51 / 1024 * self.leg_m or not 0.4 <= self.u <= tuning.AHEAD_SHARE:
            return False
        back = 1 if self.foot_speed[0] < 0 else -1
        falls, mate_falls = (back * self.residual_rate[at] for at in (leg, 3 - leg))
        pushes = behind + self.f.lag_s / self.dt * max(0.0, falls - max(0.0, mate_falls))
        knees = self.robot.knee_sign(leg) > self.robot.knee_sign(3 - leg)
        return pushes > max(41 / 1024 * self.leg_m, self.push_lag) and not (knees and self.may_be_late(leg))

    def may_be_late(self, leg):
        gone, mate_gone = (self.measured[at][0] - self.before[at][0] for at in (leg, 3 - leg))
        if self.foot_speed[0] < 0:
            gone, mate_gone = -gone, -mate_gone
        return gone > abs(self.foot_speed[0]) * self.dt or (mate_gone <= 0 and self.u > 0.4)

    def check_landing(self, leg, stood):
        """Look at a foot that stands by plan for a share of a cycle: did it land too high?"""
        if stood > tuning.LANDING_SHARE + self.delay * self.dt / self.f.cycle_s:
            self.early_contact[leg] = 0
        elif self.early_contact[leg] == 0 and self.known > self.delay and self.stands_high(leg, 51 / 1024):
            self.meet_ground(leg, 0.5)

    def meet_ground(self, leg, share):
        x, y, z = self.measured[leg]
        met = z + y * self.tilt[0] - x * self.tilt[1] + self.h - self.ground_z(x, y)
        given = met if abs(met) < 36 / 1024 * self.leg_m else met - share * met
        self.feet[leg] = [x, y, z - given]
        self.load[leg], self.early_contact[leg] = 0.25, 2

    # --- where the feet go

    def stand_feet(self, pose):
        count = sum(self.stance)
        mean_z = sum(foot[2] for foot, stands in zip(self.feet, self.stance, strict=True) if stands) / max(1, count)
        rise = (self.h + pose[2] + mean_z) / (2 * self.f.cycle_s) + self.rise_speed if count else 0.0
        (wx, wy), wz = self.level, self.turn
        for leg in range(4):
            if self.stance[leg]:
                x, y, z = self.feet[leg]
                ahead, aside = self.stance_speed
                back = ahead - wz * y + wy * z, aside + wz * x - wx * z, wx * y - wy * x + rise
                self.feet[leg] = [p - speed * self.dt for p, speed in zip((x, y, z), back, strict=True)]
                if self.known > self.delay:
                    over = max(0.0, self.residual[leg][1] - 123 / 1024 * self.leg_m)
                    self.feet[leg][2] += over * 8 * self.dt / self.f.cycle_s

    def swing_feet(self, pose):
        u = self.u
        along, down, up = way(min(1.0, u / tuning.AHEAD_SHARE)), way(u), (1 - math.cos(2 * math.pi * u)) / 2
        rising = min(1.0, max(0.0, (u - tuning.AHEAD_FROM) / (tuning.AHEAD_TO - tuning.AHEAD_FROM)))
        for leg in range(4):
            if self.stance[leg] == 0:
                rest = self.f.rests_m[leg][0] - pose[0], self.f.rests_m[leg][1] - pose[1]
                turning = -self.turn * rest[1], self.turn * rest[0]
                place, gone = [], way(rising) if self.rises_first[leg] else along
                for i in range(2):
                    target = rest[i] + self.capture[i] + (self.foot_speed[i] + turning[i]) * self.f.neutral_s
                    back = (self.stance_speed[i] + turning[i]) * self.f.swing_s
                    start = self.lift_offs[leg][i]
                    place.append(start + (target - start + back) * gone - back * u)
                start = self.lift_offs[leg][2]
                place[0] -= self.shortened[leg]
                if self.rises_first[leg] and u < 0.5:
                    back = tuning.DRAW_BACK * self.leg_m * (1 - math.cos(4 * math.pi * u)) / 2
                    place[0] -= math.copysign(back, self.foot_speed[0])
                low = self.ground_z(*place) - self.h - pose[2]
                z = start + (low - start) * down + self.apex[leg] * up
                self.feet[leg] = to_body((*place, z), *self.then)

    # --- one tick

    def tick(self, senses, speed, pose=(0.0,) * 6, moving=True, balance=True):
        """Return twelve goals. speed: m/s, m/s, rad/s, slewed; pose: m, rad, slewed."""
        self.tilt = senses.tilt
        self.estimate(senses)
        self.steer(speed, senses.rates, pose, moving, senses.went)
        self.level_body(senses.tilt, senses.rates, pose, balance)
        if self.known:
            self.update_slope()
        self.choose_care()
        self.choose_lift()
        self.moving = moving
        self.advance_legs(moving)
        self.stand_feet(pose)
        self.swing_feet(pose)
        short = [0.0 if stands else short for stands, short in zip(self.stance, self.shortened, strict=True)]
        free = [(foot[0] + less, foot[1], foot[2]) for foot, less in zip(self.feet, short, strict=True)]
        self.past.append((free, list(self.stance)))
        return self.goals()

    def goals(self):
        """Return the joints, what they give under their load, and where they will be a lag later."""
        before, self.joints = self.joints, [q for leg in range(4) for q in self.inverse(leg, self.feet[leg])]
        before = before or self.joints
        step = 0.5 / max(1.0, tuning.LOAD_SHARE * self.f.stance_s / self.dt) / (1 if self.moving else 8)
        goals = []
        for leg in range(4):
            wanted = 1 / max(1, sum(self.stance)) if self.stance[leg] else 0.0
            self.load[leg] += limit(wanted - self.load[leg], step)
            led = self.f.lag_s / self.dt * (1.0 if self.stance[leg] else 0.5)
            joints = self.joints[3 * leg : 3 * leg + 3]
            give, steps = self.sag(leg, joints, self.feet[leg]), [q - before[3 * leg + i] for i, q in enumerate(joints)]
            slides = (0.0, 0.0, 0.0)
            if self.early_contact[leg] == 2:
                self.early_contact[leg], led = 1, 0.0
            elif self.stance[leg] and not self.high_left:
                slides = self.compensate_friction(steps, give)
            for i, q in enumerate(joints):
                low, high = self.robot.joint_limits_rad(leg)[i]
                goals.append(max(low, min(high, q + give[i] + slides[i] + led * limit(steps[i], self.fastest[i]))))
        return goals

    def compensate_friction(self, steps, give):
        """Return what is led of the friction of a leg's joints, which their motors feel."""
        (hip, thigh, calf), (_, thigh_give, calf_give), coupled = steps, give, self.robot.calf_drive.coupled
        steps, give = (hip, thigh, calf + coupled * thigh), (give[0], thigh_give, calf_give + coupled * thigh_give)
        slow = tuning.FRICTION_SHARE * self.fastest[0]
        led = [limit(step / slow, 1.0) * (dry + self.of_sag * abs(given))
               for step, given, dry in zip(steps, give, self.friction, strict=True)]
        return led[0], led[1], led[2] - coupled * led[1]
