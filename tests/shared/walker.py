"""Runs the planner from its blocks: stand up, walk, sit, with every tick's feet and joints kept."""

from host.lab.parity.probe.row import Row
from shared.crawl.state import STILL
from shared.gait.gaits import GAIT_NAMES, GAITS, PAPER_TROT
from shared.gait.table import MOVER_CRAWL, MOVER_TROT, compile_gait
from shared.planner import command as c
from shared.planner import status as n
from shared.planner.planner import Planner
from shared.record import pack, unpack
from shared.sense.sensed import Sensed

from .robots import block

# Tables beside those of the registry: without pauses, each diagonal half a cycle; and one leg at a time.
EVEN_TROT = (35, 100, 100, 0), ((240, 9, 1), (240, 6, 1))
ONE_BY_ONE = (
    (40, 100, 100, 0),
    ((200, 0, 1), (400, 8, 2), (200, 0, 1), (400, 2, 2), (200, 0, 1), (400, 4, 2), (200, 0, 1), (400, 1, 2)),
)
MORE = {"even-trot": EVEN_TROT, "one-by-one": ONE_BY_ONE}
NAMES = (*GAIT_NAMES, *MORE)
# In the order of NAMES; gaits without one are not walked by it.
TABLES = (*(entry[2] or EVEN_TROT for entry in GAITS), *MORE.values())
TABLE_GAITS = {"paper-trot": PAPER_TROT} | MORE  # those that are nothing but their table

OFF, READY, ON, BACK = range(4)  # of the crawl: the trot walks, loads are waited for, it crawls, the trot backs off


def phase(planner):
    """Return OFF .. BACK of a planner."""
    if planner.status.mover != MOVER_CRAWL:
        return BACK if planner.status.backing_off else OFF
    return READY if planner.crawl.stage.stage == STILL else ON


class Walker:
    """One robot's planner with its command and senses; perfect servos: the joints are where they were sent."""

    def __init__(self, name="caramelo", rate_hz=50, knees="full-elbow"):
        self.params = block(name, rate_hz, knees)
        self.rate_hz = rate_hz
        self.unit_m = 2.0 ** -self.params.length_shift
        self.planner = Planner(self.params)
        self.planner.gaits += [compile_gait(table, self.params) for table in MORE.values()]
        self.planner.status.gaits = len(self.planner.gaits)
        self.command = c.Command()
        self.sensed = Sensed()
        self.sensed.valid.joints = self.sensed.valid.tilt = 1

    @property
    def state(self):
        return self.planner.status.state

    def mode(self, mode):
        self.command.mode = mode

    def gait(self, name):
        self.command.gait = NAMES.index(name)

    def speed(self, vx_m_s=0.0, vy_m_s=0.0, wz_rad_s=0.0):
        """Command a speed; return what the integers make of it, per tick, in m and rad."""
        per_tick = 256 / self.unit_m / self.rate_hz
        values = round(vx_m_s * per_tick), round(vy_m_s * per_tick), round(wz_rad_s * 262144 / self.rate_hz)
        unpack(self.command.speed, values)
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

    def walk(self, gait="even-trot", vx_m_s=0.05, vy_m_s=0.0, wz_rad_s=0.0):
        """Stand up and ask for a walk; returns the command per tick."""
        self.stand()
        self.gait(gait)
        asked = self.speed(vx_m_s, vy_m_s, wz_rad_s)
        self.mode(c.MODE_WALK)
        return asked

    def feet_m(self):
        """Return the four planned feet in the body, m: the trot's, or a table's before the body's pose."""
        trots = self.planner.status.mover == MOVER_TROT
        feet, unit_m = (self.planner.trot.feet, self.unit_m / 256) if trots else (self.planner.feet, self.unit_m)
        return [[v * unit_m for v in pack(foot)] for foot in feet.legs]

    def swinging(self):
        """Return the legs in the air as bits."""
        return self.planner.status.swinging
