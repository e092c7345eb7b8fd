"""The whole planner in floats and metres, on a map: the body walks over it, feet stand on points of it.

Where shared/planner/planner.py moves footholds under a body that stays where it is, this one moves the body and leaves
the footholds alone. Commands come as an object with mode, gait, speed (vx, vy, wz), pose (6), balance, height_m;
senses with roll, pitch, attitude_ok, joints (12), joints_ok, none of them odd. All in SI.
"""

import math

from . import body, goals, leg, reach
from .balance import Balance
from .fixed import limit, towards
from .swing import advance, lift

LIMP, RISING, STANDING, WALKING, SITTING, SEATED = range(6)
LIMP_MODE, STAND, WALK, SIT = range(4)


class Foot:
    """One foot: where it stands on the map, or where it left and how far its swing is."""

    def __init__(self, rest):
        self.rest = rest
        self.place = rest[:2]
        self.phases = ()
        self.tick = 0
        self.height_m = 0.0


class Planner:
    """``robot`` has legs (side_l1, l1, l2, l3, knee, hip, rest, low, high), the limits and slews, all per second."""

    def __init__(self, robot, gaits):
        self.robot = robot
        self.gaits = gaits
        self.gait = gaits[0]
        self.state = LIMP
        self.joints = [0.0] * 12
        self.wanted = [0.0] * 12
        self.known = False
        self.settle()

    def settle(self):
        """Stand at rest on a fresh map."""
        self.body = [0.0, 0.0, 0.0]
        self.speed = [0.0, 0.0, 0.0]
        self.pose = [0.0] * 6
        self.posed = [0.0] * 6
        self.feet = [Foot(one.rest) for one in self.robot.legs]
        self.balance = Balance(self.robot.gains)
        self.clock = 0
        self.first_cycle = True
        self.planned = [list(foot.rest) for foot in self.feet]
        self.flagged = [False] * 4
        self.in_air = [False] * 4
        self.held, self.out_of_reach = None, False

    def tick(self, command, sensed):
        """Plan one tick; returns the twelve joint angles."""
        if sensed.joints_ok and not self.known:
            self.known, self.joints = True, list(sensed.joints)
        self.choose(command, sensed)
        if self.state == LIMP:
            self.wanted = list(sensed.joints) if sensed.joints_ok else self.wanted
        elif self.state in (RISING, SITTING):
            self.move_joints()
        elif self.state != SEATED:
            self.walk(command)
            self.level(command, sensed)
            self.wanted = self.solve()
        self.joints = goals.follow(self.wanted, self.joints, self.robot.joint_speed_max, self.robot.coupled)
        return self.joints

    def choose(self, command, sensed):
        """Change state where the mode asks for it."""
        if command.mode == LIMP_MODE:
            self.state = LIMP
        elif command.mode == SIT:
            if self.state in (STANDING, RISING):
                self.begin(SITTING, sensed)
        elif self.state in (LIMP, SEATED, SITTING):
            self.begin(RISING, sensed)

    def begin(self, state, sensed):
        """Plan a slow move of all joints to the stance or to the seat."""
        if self.state == LIMP and not sensed.joints_ok:
            return
        self.state = state
        self.settle()
        self.start = self.joints
        self.goal = self.solve(self.robot.sit_z if state == SITTING else None)
        longest = max([abs(a - b) for a, b in zip(self.start, self.goal)])
        self.move_ticks = 1 + int(2 * longest / self.robot.joint_speed_slow)
        self.move_tick = 0

    def move_joints(self):
        """Go one tick on, on the cycloid's profile."""
        self.move_tick += 1
        share = advance(self.move_tick / self.move_ticks)
        self.wanted = [a + (b - a) * share for a, b in zip(self.start, self.goal)]
        if self.move_tick >= self.move_ticks:
            self.state += 1

    def walk(self, command):
        """Move the body over the map and the feet in the air by one tick."""
        wanted = self.gaits[command.gait]
        if self.state == STANDING:
            self.gait, self.clock = wanted, 0
        still = self.slew(command, wanted)
        if self.state == STANDING:
            if still:
                self.planned = [self.stand(foot) for foot in self.feet]
                self.in_air = [False] * 4
                return
            self.state, self.first_cycle = WALKING, True
        self.lift_feet(command)
        self.in_air = [bool(foot.phases) for foot in self.feet]
        self.move_body(self.gait.way(self.clock))
        self.planned = [
            self.swing(number, foot) if foot.phases else self.stand(foot) for number, foot in enumerate(self.feet)
        ]
        self.clock += 1
        if self.clock == self.gait.cycle:
            self.end_cycle(wanted, still)

    def end_cycle(self, wanted, still):
        """Stop if all is done, else take the gait that is asked for if it isn't too fast for it."""
        self.clock, self.first_cycle = 0, False
        if still and all(self.at_rest(number) for number in range(4)):
            self.state = STANDING
        elif all(abs(v) <= top + 1e-12 for v, top in zip(self.speed, self.top_speed(wanted))):
            self.gait = wanted

    def at_rest(self, number):
        """Return True if a foot stands where it would stand at rest."""
        foot = self.feet[number]
        x, y = self.under_body(foot.place)
        return not foot.phases and max(abs(x - foot.rest[0]), abs(y - foot.rest[1])) <= self.robot.unit_m / 16

    def top_speed(self, gait):
        """Return the fastest vx, vy, wz (per tick): the robot's own, or what makes the longest stride in a stance.

        In whole units of the speed, as the command is.
        """
        ticks = max([1] + [int(way + 1e-6) for way in gait.way_of_stance])
        radius = max([math.sqrt(one.rest[0] ** 2 + one.rest[1] ** 2) for one in self.robot.legs])
        strides = self.robot.stride, self.robot.stride, self.robot.stride / radius
        units = self.robot.speed_unit
        return [min(top, int(s / ticks / u) * u) for top, s, u in zip(self.robot.speed_max, strides, units)]

    def slew(self, command, wanted):
        """Move speed and pose towards the command; return True if the robot is not to move."""
        share = 0.0 if command.mode != WALK else 0.5 if self.state == STANDING or self.first_cycle else 1.0
        tops = [min(a, b) for a, b in zip(self.top_speed(self.gait), self.top_speed(wanted))]
        for i, top in enumerate(tops):
            target = share * limit(command.speed[i], -top, top)
            self.speed[i] = towards(self.speed[i], target, self.robot.speed_slew[i])
        self.hold(command)
        for i, top in enumerate(self.robot.pose_max):
            target = 0.0 if self.out_of_reach else self.pose[i] if self.held else limit(command.pose[i], -top, top)
            self.pose[i] = towards(self.pose[i], target, self.robot.pose_slew[i])
        return not any(self.speed)

    def hold(self, command):
        """Where a standing leg was beyond its reach: a step back, and no further on until another pose is commanded."""
        self.out_of_reach = any(self.flagged) and any(self.pose)
        if self.out_of_reach:
            self.held = self.held or list(command.pose)
        elif self.held != command.pose:
            self.held = None

    def lift_feet(self, command):
        """Start the swings of this tick."""
        for number, foot in enumerate(self.feet):
            ticks = self.gait.lifts(number, self.clock)
            if ticks:
                foot.phases = self.gait.phases(ticks)
                foot.tick = 0
                foot.height_m = command.height_m or self.gait.height_m
                foot.height_m = limit(foot.height_m, 0.0, -self.robot.sit_z)

    def move_body(self, way):
        """Turn, then go: ``way`` is in ticks of the present speed."""
        vx, vy, wz = [way * v for v in self.speed]
        self.body[2] += wz
        c, s = math.cos(self.body[2]), math.sin(self.body[2])
        self.body[0] += c * vx - s * vy
        self.body[1] += s * vx + c * vy

    def under_body(self, place):
        """Return a point of the map as seen from the body."""
        x, y = place[0] - self.body[0], place[1] - self.body[1]
        c, s = math.cos(self.body[2]), math.sin(self.body[2])
        return c * x + s * y, c * y - s * x

    def on_map(self, x, y):
        """Return on the map what the body sees at (x, y)."""
        c, s = math.cos(self.body[2]), math.sin(self.body[2])
        return self.body[0] + c * x - s * y, self.body[1] + s * x + c * y

    def foothold(self, number, foot):
        """Return where the foot is to land, seen from the body: half the way of its stance before rest."""
        left = len(foot.phases) - 1 - foot.tick
        ticks = self.gait.way_of_stance[number] / 2 + self.gait.way_ahead(self.clock + 1, left)
        vx, vy, wz = self.speed
        turn = limit(wz * ticks, -1.0, 1.0)
        return foot.rest[0] + vx * ticks - turn * foot.rest[1], foot.rest[1] + vy * ticks + turn * foot.rest[0]

    def stand(self, foot):
        """Return a standing foot as the body, at rest, would see it."""
        return list(self.under_body(foot.place)) + [foot.rest[2]]

    def swing(self, number, foot):
        """Carry one foot through one tick of the air; return it likewise."""
        phase = foot.phases[foot.tick]
        target = self.foothold(number, foot)
        share = advance(phase)
        at = [a + (b - a) * share for a, b in zip(self.under_body(foot.place), target)]
        foot.tick += 1
        if foot.tick == len(foot.phases):
            foot.place, foot.phases = self.on_map(target[0], target[1]), ()
        return at + [foot.rest[2] + foot.height_m * lift(phase)]

    def level(self, command, sensed):
        """Add balance to the body pose."""
        if command.balance and sensed.attitude_ok:
            extra = self.balance.step(self.pose[3:5], (sensed.roll, sensed.pitch))
        else:
            extra = self.balance.release(self.robot.pose_slew[3])
        self.posed = self.pose[:3] + [self.pose[3] + extra[0], self.pose[4] + extra[1], self.pose[5]]

    def solve(self, sit_z=None):
        """Return the joints for the planned feet and pose, or with the feet raised to the seat's height.

        Keeps which standing legs are beyond their reach, and how close one is to the edge of that.
        """
        joints = []
        self.edge_m, self.edge_rad = 1.0, 1.0
        for number, (one, foot) in enumerate(zip(self.robot.legs, self.planned)):
            if sit_z is not None:
                foot = list(foot[:2]) + [one.hip[2] + sit_z]
            wanted = body.from_base(self.posed, foot, one.hip)
            clear = reach.clear_of_hip(wanted, one)
            hip_foot, reasons = reach.clamp(clear, one.l1, one.l2, one.l3, reach.usable(one))
            angles = leg.inverse(hip_foot, one.side_l1, one.l2, one.l3, one.knee)
            limited = [limit(q, low, high) for q, low, high in zip(angles, one.low, one.high)]
            cut = reasons or wanted[2] > clear[2] or limited != list(angles)
            self.flagged[number] = bool(cut) and not self.in_air[number]
            if not self.in_air[number]:
                self.edge_m = min([self.edge_m] + [abs(distance_m) for distance_m in reach.to_ends(wanted, one)])
                self.edge_rad = min([self.edge_rad] + [abs(a - b) for a, b in zip(angles * 2, one.low + one.high)])
            joints += limited
        return joints
