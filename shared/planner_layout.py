"""Where the planner keeps its numbers: its states, what it is told is sensed, its flags, its own block."""

from .runtime import const

LIMP = const(0)
RISING = const(1)
STANDING = const(2)
WALKING = const(3)
SITTING = const(4)
SEATED = const(5)
STATE_NAMES = ("limp", "rising", "standing", "walking", "sitting", "seated")

# What is sensed, one block
S_ROLL = const(0)  # brad
S_PITCH = const(1)
S_ATTITUDE_OK = const(2)  # 1: roll and pitch may be used
S_JOINTS = const(3)  # 12 brad, as measured
S_JOINTS_OK = const(15)  # 1: the measured joints may be used
S_RATES = const(16)  # 3 values: turn about x, y, z in this tick without the gyro's bias, 2^-18 rad
S_RATES_OK = const(19)  # 1: they may be used
SENSED_SIZE = const(20)

# Flags of a tick
REACH_FLAGS = const(0x07)  # a foot was out of reach: TOO_FAR, TOO_NEAR, INSIDE_HIP
LIMIT_FLAGS = const(0x38)  # a joint was at its limit: LIMIT_HIP, LIMIT_THIGH, LIMIT_CALF
NOT_DRIVEN = const(0x40)  # the joints are not to be held
NO_ATTITUDE = const(0x80)  # balance was asked for and there is no attitude
NO_JOINTS = const(0x100)  # standing up was asked for and the joints' positions are not known
BAD_COMMAND = const(0x200)  # a mode or gait that does not exist: taken as standing, as the last gait
BLIND = const(0x400)  # the adaptive trot lacks measured joints, attitude or turning rates: it walks on expectations
ODD_READING = const(0x1000)  # a reading was too far from the one before it to be true: that one is gone by
POSE_HELD = const(0x2000)  # the commanded pose is out of reach: the body stays where the standing legs end
FALLEN = const(0x800)  # tilted too far for too long: it sits down, until told to sit or to be limp

# The planner's own numbers, one block
N_STATE = const(0)
N_GAIT = const(1)  # the gait being walked
N_HEIGHT = const(2)  # lu, its swing height
N_FLAGS = const(3)
N_SWINGING = const(4)  # legs in swing, bits
N_GAITS = const(5)  # how many gaits there are
N_CYCLES = const(6)  # 0 in the first cycle after standing
N_MARGIN = const(7)  # lu, static stability margin: the centre of mass in the polygon of the standing feet
N_ADVICE = const(8)  # ADVICE_... of the adaptive trot: whether another gait would do better
N_TILTED = const(9)  # ticks in a row of too much tilt
N_FALLEN = const(10)  # 1: fallen
N_CLIMB = const(11)  # the crawl over obstacles: CLIMB_...
N_REASON = const(12)  # why trot and crawl were last exchanged, handover.REASON_...
N_WAITED = const(13)  # ticks for which the commanded crawl has waited for level feet
N_MET = const(14)  # 1: the joints have been known
N_HELD = const(15)  # 6 values: the commanded pose that was out of reach, lu and brad
N_HOLDS = const(21)  # 1: it was
N_BEYOND = const(22)  # 1: a standing leg was out of reach or at its limits in the last tick
N_SIZE = const(23)

CLIMB_OFF = const(0)
CLIMB_READY = const(1)  # standing still until the joints' loads are known
CLIMB_ON = const(2)
CLIMB_BACK = const(3)  # the held-up trot backs off from the edge first
