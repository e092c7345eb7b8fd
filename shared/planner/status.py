"""What the planner reports: its states, the flags of a tick, its status."""

from ..body.axes import Pose
from ..record import field, part, record
from ..runtime import const

LIMP = const(0)
RISING = const(1)
STANDING = const(2)
WALKING = const(3)
SITTING = const(4)
SEATED = const(5)
FOLDING = const(6)  # on its belly: the robot moves its legs to its sides, then under it
STATE_NAMES = ("limp", "rising", "standing", "walking", "sitting", "seated", "folding")

CARRIES_NOT = const(0)  # the feet were never felt to carry the robot, or carry nothing any more
CARRIES = const(1)  # the feet carry the robot
POSED = const(2)  # they carried it, until the commanded pose moved the body

# Flags of a tick
# Bits 0 .. 2: a foot was out of reach, TOO_FAR, TOO_NEAR, INSIDE_HIP; 3 .. 5: a joint was at its limit, LIMIT_HIP ..
NOT_DRIVEN = const(0x40)  # the joints are not to be held
NO_ATTITUDE = const(0x80)  # balance is commanded but the attitude is not known
NO_JOINTS = const(0x100)  # standing up is commanded but the joints' positions are not known
BAD_COMMAND = const(0x200)  # no such mode: the robot stands; or no such gait: the last one is kept
BLIND = const(0x400)  # joints, attitude or turning rates are missing: the trot walks without feedback, the crawl stands
ODD_READING = const(0x1000)  # a reading was too far from the one before it to be believed: the one before it is used
POSE_HELD = const(0x2000)  # the commanded pose is out of reach: the body stops where the stance legs' reach ends
FALLEN = const(0x800)  # tilted too far for too long: the robot sits down, until commanded to sit or to be limp
LIFTED = const(0x4000)  # the feet no longer carry it: the legs hold still until it is put down and told anew to walk


@record
class Status:
    """What the planner of one robot does and reports: its state, flags and counts."""

    state: int = field("", "LIMP .. FOLDING")
    gait: int = field("", "the gait being walked")
    height: int = field("lu", "swing height of the gait")
    flags: int = field("", "flags of this tick")
    swinging: int = field("", "legs in swing, bits")
    gaits: int = field("", "how many gaits there are")
    cycles: int = field("", "0 in the first cycle after standing")
    margin: int = field("lu", "static stability margin: how far the centre of mass is inside the support")
    tilted: int = field("ticks", "for how long the tilt has been too large")
    fallen: int = field("", "1: fallen")
    mover: int = field("", "MOVER_...: the current mover")
    backing_off: int = field("", "1: a held-up trot backs off before it gives way to the crawl")
    reason: int = field("", "why trot and crawl last took over from each other, handover.REASON_...")
    joints_seen: int = field("", "1: the joints have been known at least once")
    held_pose: Pose = part(Pose, "the commanded pose that was out of reach")
    pose_held: int = field("", "1: the body is held back from that pose")
    out_of_reach: int = field("", "1: a stance leg was out of reach or at its limits in the last tick")
    pose_moves: int = field("", "1: the commanded pose moves the body in this tick")
    carries_weight: int = field("", "CARRIES_NOT .. POSED: what the feet were last felt to carry")
    feet_load_q12: int = field("own weight Q12", "what the feet carry together, averaged over 0.2 s")
    folded: int = field("", "1: a robot on its belly has folded its legs at its sides, and now puts them under it")
    lifted: int = field("", "1: lifted off the ground, and not yet put down and commanded to stand")

