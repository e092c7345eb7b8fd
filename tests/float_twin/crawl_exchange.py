"""Who walks, trot or crawl, from docs/gaits.md: when the crawl begins, when the trot backs off first, when it ends.

Speeds are per tick. A command comes as an object with walk (bool), gait and speed (vx, vy, wz); what is known of the
robot with joints_ok, attitude_ok, fallen, standing, walked (the gait), held (the trot is held up for good), moved (m,
forwards in the last tick), known (ticks measured in a row); of the crawl with resting and even_landings (in a row on
even ground).
"""

OFF, READY, ON, BACK = range(4)
NO_REASON, HELD, COMMAND, EVEN = range(4)
TROT, CRAWL = FEELING = 1, 2
TROT_LANDINGS = 16


class Retreat:
    """The held-up trot walks back; robot: leg_m, speed_max (per tick), rate_hz."""

    def __init__(self, robot, doubt):
        self.robot, self.doubt = robot, doubt
        self.back_m, self.ticks, self.stood, self.ends = 0.0, 0, 0, False

    def step(self, moved_m, standing):
        """Take one tick; return (vx to walk with, True once it has stood for half a second)."""
        self.back_m -= moved_m
        self.ticks += 1
        far_enough = not self.doubt.above(0.3 * self.robot.leg_m, self.back_m, 1e-7)
        self.ends = self.ends or far_enough or self.ticks > 6 * self.robot.rate_hz
        self.stood = self.stood + 1 if self.ends and standing else 0
        return 0.0 if self.ends else -0.1 * self.robot.speed_max[0], self.stood > self.robot.rate_hz / 2


def can_follow(robot, speed):
    """Return whether the crawl can go that way: no more sideways than forwards, a twelfth of the fastest turn."""
    vx, vy, wz = speed
    return vx > 0 and abs(vy) <= vx and abs(wz) <= robot.speed_max[2] / 12


class Exchange:
    """The exchange of one robot; robot: what Retreat needs, delay_ticks; gaits: how many there are."""

    def __init__(self, robot, gaits, doubt):
        self.robot, self.gaits, self.doubt = robot, gaits, doubt
        self.stage, self.reason, self.blind = OFF, NO_REASON, False
        self.walked, self.retreat = None, None

    def takes(self, command, known):
        """Return whether this tick is the crawl's; what else has changed is in stage, reason and the gait walked.

        Who stands walks in the commanded gait next.
        """
        self.blind, self.walked = False, known.walked
        gait = self.wanted(command)
        if known.standing:
            self.walked = gait
        if self.stage == BACK:
            return self.backs_off(command, known)
        reason = self.why_begin(command, known)
        if not reason:
            return False
        if not senses(known):
            self.blind = True
            return False
        self.reason = reason
        if reason == HELD:
            self.stage, self.retreat = BACK, Retreat(self.robot, self.doubt)
            return False
        self.stage, self.walked = READY, gait
        return True

    def why_begin(self, command, known):
        """Return why the crawl is to begin now, commanded from a stand, or the trot to back off; or NO_REASON."""
        if not command.walk or known.fallen or not can_follow(self.robot, command.speed):
            return NO_REASON
        if self.walked == CRAWL and known.standing:
            return COMMAND
        return HELD if known.held else NO_REASON

    def backs_off(self, command, known):
        """Take one tick of backing off; return whether it is done. Another command or missing senses end it."""
        wanted = command.walk and self.wanted(command) in FEELING and can_follow(self.robot, command.speed)
        if known.fallen or not wanted or not senses(known):
            self.stage = OFF
            return False
        done = self.retreat.step(known.moved, known.standing)[1]
        if done:
            self.stage, self.walked = READY, self.wanted(command)
        return done

    def wanted(self, command):
        """Return the commanded gait; an unknown one is the one that is walked."""
        return command.gait if 0 <= command.gait < self.gaits else self.walked

    def why_end(self, command, crawl):
        """Return why the crawl is to give back, or NO_REASON; a crawl that goes on is part of the commanded gait."""
        gait = self.wanted(command)
        if not command.walk:
            return NO_REASON
        if gait not in FEELING:
            return COMMAND
        if not any(command.speed):
            return NO_REASON
        if not can_follow(self.robot, command.speed):
            return COMMAND
        if gait == TROT and self.walked != TROT:
            return COMMAND
        self.walked = gait
        return EVEN if gait == TROT and crawl.even_landings >= TROT_LANDINGS else NO_REASON

    def begin_crawl(self, known):
        """Begin the crawl proper once the loads are known: a measurement later than the last goal's effect."""
        self.blind = not senses(known)
        if not self.blind and self.stage == READY and known.known > self.robot.delay_ticks + 1:
            self.stage = ON

    def end_crawl(self, command, known, reason, resting):
        """Return the planner's standing (True) or walking (False) after a tick of the crawl; it may have ended."""
        goes = command.walk and not known.fallen and not reason and command.speed[0] > 0
        if resting and reason:
            self.stage, self.reason = OFF, reason
            return False
        return resting and not goes


def senses(known):
    """Return whether the crawl has what it needs."""
    return bool(known.joints_ok and known.attitude_ok)


def faded(goal, jump, left, ticks):
    """Return a goal to which what is left of a jump is added."""
    return goal + jump * left / ticks
