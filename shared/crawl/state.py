"""All that the crawl of one robot remembers, made beforehand: a tick allocates nothing."""

from ..body.axes import POSE_AXES, Point, Pose, Spot
from ..body.feet import Feet
from ..body.load import Load
from ..body.params import JOINTS, LEGS, Params
from ..record import field, part, parts, record, vector
from ..runtime import Ints, const, zeros

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
EVENT_CALF = const(4)  # the calf, not the foot, stands on an edge
EVENT_RISER = const(5)  # the foot ran into a riser
EVENT_NO_GROUND = const(6)  # no ground at all: the foot is left hanging
EVENT_DIAGONALS = const(7)  # the loads of the diagonals could not be brought to what was wanted
EVENT_SINKS = const(8)  # the body sank over the leg in the air: it is put down at once
EVENT_RIM = const(9)  # ground close beside where there was none: another try as far again

FULL_SHARE_Q12 = const(4096)
HISTORY_TICKS = const(32)  # ticks
MOST_FOOTHOLDS = const(4)  # of a side


@record
class Map:
    """Places: x forward as the crawl was started, y left, z up. The origin moves along with the body.

    ``lf`` is lu/256, ``bf`` brad/256 (2^-24 turn): fine units, so that one filter serves all axes of a pose.
    """

    feet: list[Point] = parts(LEGS, Point, "where FR, FL, RR, RL stand, lf")
    measured: list[Point] = parts(LEGS, Point, "where they are by the measured joints, lf")
    body_pose: Pose = part(Pose, "where the body is, lf, bf")
    calf_pitch: Ints = vector(LEGS, "brad", "pitch of the calf in the tick before")


@record
class Support:
    """Which legs stand, and what they carry. Forces are parts of the robot's own weight in Q12."""

    stance: Ints = vector(LEGS, "", "1: the leg stands")
    share_q12: Ints = vector(LEGS, "", "share of the load that it is to take, 0 .. 4096")
    force_q12: Ints = vector(LEGS, "own weight", "vertical force on the foot, from the joints")
    load_q12: Ints = vector(LEGS, "own weight", "force that it should have")
    weight_q20: int = field("own weight", "carried, payload included, as the feet tell it")
    weight_q12: int = field("own weight", "the same within 0.7 .. 2.5")
    payload_q12: int = field("", "payload: 0 up to 1.15 own weights, 4096 from 1.65 on")
    diagonal_offset: int = field("lf", "of the feet FR, RL upwards, of the other two downwards")
    margin: int = field("lu", "centre of mass inside the support polygon")


@record
class Queue:
    """Footholds to come of a hind foot."""

    places: list[Point] = parts(MOST_FOOTHOLDS, Point, "where they are, the oldest first, lf")
    waiting: int = field("", "how many there are")
    guessed: int = field("", "how many of the oldest no front foot has stood on")
    occupied: int = field("", "1: the front foot of the side still stands on the last")


@record
class Footholds:
    """Footholds to come of the hind feet."""

    sides: list[Queue] = parts(2, Queue, "right, left")


@record
class BodyPath:
    """The body's path, in lf and bf."""

    wanted: Pose = part(Pose, "where it should be in this tick")
    from_pose: Pose = part(Pose, "where its move began")
    to_pose: Pose = part(Pose, "where its move ends")
    move_tick: int = field("ticks", "of the move so far")
    move_ticks: int = field("ticks", "of the whole move")
    lagged: Ints = vector(POSE_AXES, "lf, bf", "the wanted pose, as late as servos and bus are")
    integral: Ints = vector(POSE_AXES, "lf, bf", "of the pose loop")
    commanded: Pose = part(Pose, "pose that the stance legs are told")
    deviation: Ints = vector(POSE_AXES, "lf, bf", "measured less wanted pose, smoothed")


@record
class Swing:
    """The foot in the air."""

    place: Point = part(Point, "where the foot is wanted, lf")
    departure: Spot = part(Spot, "where its way across began, lf")
    target: Point = part(Point, "the foothold aimed at, lf")
    ground: int = field("lf", "expected height of the ground there")
    known: int = field("", "1: a front foot has stood there")
    apex: int = field("lf", "height up to which it is lifted")
    speed: int = field("lf / tick", "up or down")
    way_ticks: int = field("ticks", "of the way across")
    tries: int = field("", "how often it was lifted once more")
    risers: int = field("", "how many risers it ran into")
    dropped: int = field("", "sign of the way that the last drop it met sends it: 1 further on, -1 nearer; 0: none")
    leg_length: int = field("lu", "thigh joint to foot, before any limit")
    limited: int = field("", "1: a joint was limited in the tick before")


@record
class Contact:
    """What the leg in the air feels."""

    tare_q12: int = field("own weight", "force that it reads without contact")
    load_ticks: int = field("ticks", "with load, in a row")
    peak: int = field("", "1: more than the least of a contact in one of them")
    past_x: Ints = vector(HISTORY_TICKS, "lf", "x that the foot was sent to in the ticks before, in a ring")
    past_at: int = field("", "where the last is")


@record
class Ground:
    """How even the ground has been."""

    landings: int = field("", "of all legs since the start")
    even_landings: int = field("", "of these the last in a row on even ground")


@record
class Stage:
    """The state machine."""

    stage: int = field("", "SHIFT .. STILL")
    stage_tick: int = field("ticks", "of the stage")
    order: int = field("", "place in the order of the legs, 0 .. 3")
    leg: int = field("", "the leg that it is about")
    ahead: int = field("lf", "how far the command is ahead of the steps made")


@record
class Event:
    """What a leg met last, to be told."""

    code: int = field("", "EVENT_NONE .. EVENT_RIM")
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
        self.ground = Ground()
        self.event = Event()
        self.goals = zeros(JOINTS)  # brad, of the tick before
        self.jumps = zeros(JOINTS)  # bf, what is left of the jumps where stance and swing meet
        self.load = Load()
        self.flags = zeros(LEGS)  # leg.LIMIT_...: which joints of each leg were limited
        self.weights = zeros(LEGS)
        self.point = Spot()  # lu
        self.pose = Pose()
        self.level = Pose()
        self.rotation = zeros(9)
        self.feet = Feet()  # lu
        self.hip_feet = Feet()  # lu from the hips
        self.reached = Feet()  # the same, within reach
        self.joints = zeros(JOINTS)
