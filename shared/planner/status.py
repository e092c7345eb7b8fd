"""What the planner tells: its states, the flags of a tick, its status."""

from ..body.axes import Pose
from ..record import field, part, record
from ..runtime import const

LIMP = const(0)
RISING = const(1)
STANDING = const(2)
WALKING = const(3)
SITTING = const(4)
SEATED = const(5)
FOLDING = const(6)  # on its belly: the legs go to its sides, then under it
STATE_NAMES = ("limp", "rising", "standing", "walking", "sitting", "seated", "folding")

CARRIES_NOT = const(0)  # the feet were never felt to carry the robot, or carry nothing any more
CARRIES = const(1)  # they do
POSED = const(2)  # they did, until the commanded pose moved the body

# Flags of a tick
# Bits 0 .. 2: a foot was out of reach, TOO_FAR, TOO_NEAR, INSIDE_HIP; 3 .. 5: a joint was at its limit, LIMIT_HIP ..
NOT_DRIVEN = const(0x40)  # the joints are not to be held
NO_ATTITUDE = const(0x80)  # balance was asked for and there is no attitude
NO_JOINTS = const(0x100)  # standing up was asked for and the joints' positions are not known
BAD_COMMAND = const(0x200)  # a mode or gait that does not exist: taken as standing, as the last gait
BLIND = const(0x400)  # joints, attitude or turning rates are missing: the trot walks on expectations, the crawl stands
ODD_READING = const(0x1000)  # a reading was too far from the one before it to be true: that one is gone by
POSE_HELD = const(0x2000)  # the commanded pose is out of reach: the body stays where the standing legs end
FALLEN = const(0x800)  # tilted too far for too long: it sits down, until told to sit or to be limp
LIFTED = const(0x4000)  # its feet no longer carry it: the legs hold still until it is put down and told anew to walk


@record
class Status:
    """What the planner of one robot does and tells: its state, flags and counts."""

    state: int = field("", "LIMP .. FOLDING")
    gait: int = field("", "the gait being walked")
    height: int = field("lu", "swing height of the gait")
    flags: int = field("", "flags of this tick")
    swinging: int = field("", "legs in swing, bits")
    gaits: int = field("", "how many gaits there are")
    cycles: int = field("", "0 in the first cycle after standing")
    margin: int = field("lu", "static stability margin: the centre of mass in the polygon of the standing feet")
    tilted: int = field("ticks", "in a row of too much tilt")
    fallen: int = field("", "1: fallen")
    mover: int = field("", "MOVER_...: what has the ticks now")
    backing_off: int = field("", "1: a held-up trot backs off before it gives way to the crawl")
    reason: int = field("", "why trot and crawl were last exchanged, handover.REASON_...")
    joints_seen: int = field("", "1: the joints have been known")
    held_pose: Pose = part(Pose, "the commanded pose that was out of reach")
    pose_held: int = field("", "1: it was")
    beyond: int = field("", "1: a standing leg was out of reach or at its limits in the last tick")
    pose_moves: int = field("", "1: the commanded pose moves the body in this tick")
    carries_weight: int = field("", "CARRIES_NOT .. POSED: what the feet were last felt to carry")
    feet_load_q12: int = field("own weight Q12", "what they carry together, evened over 0.2 s")
    folded: int = field("", "1: the legs of one that lies on its belly are folded beside it, and go under it")
    lifted: int = field("", "1: lifted off the ground, and not yet put down and told to stand")

