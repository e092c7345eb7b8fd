"""All that the crawl of one robot remembers, made beforehand: a tick allocates nothing."""

from ..body.load import Load
from ..body.params import JOINTS, LEGS, Params
from ..body.pose import POSE_SIZE
from ..record import field, record
from ..runtime import const, zeros
from .contact import Contact
from .even import Evenness
from .footholds import Footholds
from .map import Map, Support
from .pose import BodyPath
from .swing import Swing

# The stages of a step
SHIFT = const(0)  # all feet down, the body moves off the leg to come
LIFT = const(1)  # its foot goes up
SWING = const(2)  # and across
HANG = const(3)  # hangs: what its joints feel is no load
LOWER = const(4)  # and comes down, until there is contact
REST = const(5)  # all feet down, nothing to do
STILL = const(6)  # before the first step: standing still until the joints' loads are known

# What a leg has met
EVENT_NONE = const(0)
EVENT_LANDED = const(1)
EVENT_STEP = const(2)  # ground higher than expected: another try further on
EVENT_DROP = const(3)  # no ground where it was expected: another try further out
EVENT_SHIN = const(4)  # the shin, not the foot, stands on an edge
EVENT_RISER = const(5)  # the foot ran into a riser
EVENT_NO_GROUND = const(6)  # no ground at all: the foot is left hanging
EVENT_WARP = const(7)  # the loads of the diagonals could not be brought to what was wanted


@record
class Stage:
    """The state machine."""

    stage: int = field("", "SHIFT .. STILL")
    stage_tick: int = field("ticks", "of the stage")
    turn: int = field("", "place in the order of the legs, 0 .. 3")
    leg: int = field("", "the leg that it is about")
    ahead: int = field("lf", "how far the command is ahead of the steps made")


@record
class Event:
    """What a leg met last, to be told."""

    code: int = field("", "EVENT_NONE .. EVENT_WARP")
    leg: int = field("", "which")
    z: int = field("lu", "off the expected height")
    number: int = field("", "how many so far: a change is news")


class Crawl:
    """The crawl of one robot at one rate: its state by parts, and scratch blocks. ``crawl_tick`` allocates nothing."""

    def __init__(self, params: Params):
        self.params = params
        self.stage = Stage()
        self.map = Map()
        self.support = Support()
        self.footholds = Footholds()
        self.path = BodyPath()
        self.swing = Swing()
        self.contact = Contact()
        self.even = Evenness()
        self.event = Event()
        self.goals = zeros(JOINTS)  # brad, of the tick before
        self.jumps = zeros(JOINTS)  # bf, what is left of the jumps where stance and swing meet
        self.load = Load()
        self.weights = zeros(LEGS)
        self.point = zeros(2)
        self.pose = zeros(POSE_SIZE)
        self.level = zeros(POSE_SIZE)
        self.rotation = zeros(9)
        self.feet = zeros(JOINTS)
        self.hip_feet = zeros(JOINTS)
        self.reached = zeros(JOINTS)
        self.joints = zeros(JOINTS)
