"""Runs the planner from its blocks: stand up, walk, sit, with every tick's feet and joints kept."""

from host.parity.probe.row import Row
from shared.gait.gaits import GAIT_NAMES
from shared.planner import command as c
from shared.planner import status as n
from shared.planner.planner import Planner
from shared.sense.sensed import Sensed

from .robots import block

# Those that are nothing but their table.
TABLE_GAITS = tuple(name for name in GAIT_NAMES if name not in ("adaptive", "climb"))


class Walker:
    """One robot's planner with its command and senses; perfect servos: the joints are where they were sent."""

    def __init__(self, name="caramelo", rate_hz=50, knees="full-elbow"):
        self.params = block(name, rate_hz, knees)
        self.rate_hz = rate_hz
        self.unit_m = 2.0 ** -self.params.length_shift
        self.planner = Planner(self.params)
        self.command = c.Command()
        self.sensed = Sensed()
        self.sensed.valid.joints = self.sensed.valid.tilt = 1

    @property
    def state(self):
        return self.planner.status.state

    def mode(self, mode):
        self.command.mode = mode

    def gait(self, name):
        self.command.gait = GAIT_NAMES.index(name)

    def speed(self, vx_m_s=0.0, vy_m_s=0.0, wz_rad_s=0.0):
        """Command a speed; return what the integers make of it, per tick, in m and rad."""
        per_tick = 256 / self.unit_m / self.rate_hz
        values = round(vx_m_s * per_tick), round(vy_m_s * per_tick), round(wz_rad_s * 262144 / self.rate_hz)
        self.command.speed[:] = values
        return values[0] * self.unit_m / 256, values[1] * self.unit_m / 256, values[2] / 262144

    def tick(self):
        """One tick; returns the flags."""
        flags = self.planner.tick(self.command, self.sensed)
        self.sensed.joints[:] = self.planner.joints
        return flags

    def sensed_row(self):
        """Return what is sensed as one row of integers, in the order of a recording."""
        sensed, valid = self.sensed, self.sensed.valid
        return Row(sensed.tilt, (valid, 0), sensed.joints, (valid, 1), sensed.turned, (valid, 2))

    def ticks(self, count):
        """Several ticks; returns all flags seen."""
        seen = 0
        for _ in range(count):
            seen |= self.tick()
        return seen

    def until(self, state, seconds=30):
        """Tick until the planner is in a state; returns the ticks it took."""
        for count in range(seconds * self.rate_hz):
            self.tick()
            if self.state == state:
                return count + 1
        raise AssertionError(f"not {n.STATE_NAMES[state]} after {seconds} s but {n.STATE_NAMES[self.state]}")

    def stand(self):
        """Stand up from limp."""
        self.mode(c.MODE_STAND)
        return self.until(n.STANDING)

    def walk(self, gait="trot", vx_m_s=0.05, vy_m_s=0.0, wz_rad_s=0.0):
        """Stand up and ask for a walk; returns the command per tick."""
        self.stand()
        self.gait(gait)
        asked = self.speed(vx_m_s, vy_m_s, wz_rad_s)
        self.mode(c.MODE_WALK)
        return asked

    def feet_m(self):
        """Return the four planned feet in the base frame, m."""
        feet = self.planner.feet
        return [[v * self.unit_m for v in feet[3 * leg : 3 * leg + 3]] for leg in range(4)]

    def swinging(self):
        """Return the legs in the air as bits."""
        return self.planner.status.swinging
