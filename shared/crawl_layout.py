"""Where the crawl keeps its numbers: the settings of one robot at one rate, and its state.

Fine units, the same for all axes of a pose so that one filter serves them all: ``lf`` is lu/256, ``bf`` is
brad/256 (2^-24 turn). Forces and loads are parts of the robot's own weight in Q12 (4096 = all of it).
The map: x forward as the crawl was started, y left, z up, origin moved along with the body.
"""

from .runtime import const

# Settings, written once by crawl_setup
K_RATE = const(0)  # ticks a second
K_STRIDE = const(1)  # lu, a third of the hip distance: front prints lie where the hind feet want them
K_HEIGHT = const(2)  # lu, hips above the mean of the feet
K_TALL = const(3)  # lu, more of it under load: straighter knees
K_REACH = const(4)  # lu, longest planned leg, hip to foot in the leg's plane
K_REACH_SWING = const(5)  # lu, the same of a leg in the air
K_NEAR = const(6)  # lu, a leg as short as this is folded
K_MARGIN = const(7)  # lu, centre of mass inside every edge of the support triangle
K_AHEAD = const(8)  # lu, centre of mass further forward under load: relieves the rear knees
K_COM_X = const(9)  # lu, centre of mass in the body
K_COM_Z = const(10)
K_ACC = const(11)  # lu / s^2 of the body's moves
K_BODY_V = const(12)  # lf / tick, the body up and down, and the hips under pitch
K_BODY_TICKS = const(13)  # shortest move of the body
K_SETTLE = const(14)  # ticks after a move
K_SHARE = const(15)  # Q12 a tick: load share of a leg 0 -> 1
K_SHARE_TICKS = const(16)  # ticks of that
K_LIFT_FRONT = const(17)  # lu
K_LIFT_REAR = const(18)
K_V_UP = const(19)  # lf / tick
K_A_UP = const(20)  # lf / tick^2
K_BRAKE = const(21)  # lf / tick^2, twice the deceleration at the top
K_V_TOP = const(22)  # lf / tick, speed left at the top
K_MOVE_TICKS = const(23)  # shortest move of a foot
K_MOVE_PACE = const(24)  # lf / tick, mean speed of a foot's move
K_TARE_TICKS = const(25)
K_TARE_SKIP = const(26)  # ticks before the first tare
K_V_TARE = const(27)  # lf / tick
K_A_DOWN = const(28)  # lf / tick^2
K_V_FRONT = const(29)  # lf / tick: contact may come at any time
K_V_REAR = const(30)  # far above a known print
K_V_SLOW = const(31)  # near it
K_V_QUICK = const(32)  # a foot faster than this is not to touch yet
K_NEAR_PRINT = const(33)  # lu
K_DEEPEST = const(34)  # lu below the expected height: give up
K_TOUCH_TICKS = const(35)  # ticks of load that make a contact
K_HIT_AFTER = const(36)  # ticks of a move before a riser can be noticed
K_HIT = const(37)  # lu, foot behind its command
K_HIT_LAG = const(38)  # ticks: a moving foot is that much late anyway
K_LATE = const(39)  # ticks: goal sent to goal reached, for the riser
K_HIGH = const(40)  # lu: an edge, up or down
K_VOID = const(41)  # lu below the expected height with nothing there
K_ADVANCE = const(42)  # lu, further on after a corner
K_ADVANCE_VOID = const(43)  # lu, further out beyond a drop
K_BACK = const(44)  # lu, hind foot off a corner
K_HIT_BACK = const(45)
K_RAISE = const(46)  # lu above the contact for another try
K_CLEAR = const(47)  # lu above the expected height for another try
K_SHIN = const(48)  # lu, this corner of the body pushed up: the shin stands on an edge
K_SHIN_RAISE = const(49)
K_TOO_HIGH = const(50)  # lu above the expected height: no contact
K_ARM_X = const(51)  # lu, the body's corners
K_ARM_Y = const(52)
K_LAG = const(53)  # Q15 a tick: servos and bus behind the pose that is wanted
K_KI = const(54)  # Q15 a tick
K_LIMIT_X = const(55)  # lf, limit of the pose loop's terms
K_LIMIT_A = const(56)  # bf
K_LOW = const(57)  # Q15 a tick: the pose a swing leg starts from
K_FADE = const(58)  # Q15 a tick: what is left of a goal's jump
K_TARE_SLOW = const(59)  # Q15 a tick
K_TARE_FAST = const(60)
K_SLIP_XY = const(61)
K_SLIP_Z = const(62)
K_SLIP_FAR = const(63)
K_FAR = const(64)  # lf, a foot that much off its place in the map
K_WEIGHT = const(65)  # Q15 a tick
K_ROLL_Q8 = const(66)  # lf / brad: the round foot rolls
K_WARP = const(67)  # lf / tick of warp per own weight of diagonal load
K_WARP_V = const(68)  # lf / tick
K_WARP_MAX = const(69)  # lf
K_WARP_TICKS = const(70)  # longest wait for the warp
K_REBASE = const(71)  # lf, the map's origin follows when the body is farther away
K_PACE = const(72)  # lf, what a step of one leg brings the body forward
K_STALLED = const(73)  # ticks
K_FORCE = const(75)  # Q15 a tick: forces smoothed over 20 ms
K_TARE_IN = const(76)  # Q15 a tick
K_PLANAR = const(74)  # 1: no lateral motion, no roll and yaw (a robot held in the plane)
K_SIZE = const(80)

# State: the map
C_FOOT = const(0)  # 12 lf: where the feet stand
C_SEEN = const(12)  # 12 lf: where the measured joints say they are
C_SHANK = const(36)  # 4 brad: slope of the shank a tick ago
C_BODY = const(40)  # 6: x y z lf, roll pitch yaw bf: where the body is
C_STANDS = const(46)  # 4: 1 = the leg stands
C_SHARE = const(50)  # 4 Q12: share of the load it is to take
C_FORCE = const(54)  # 4 Q12: vertical force on the foot, from the joints
C_LOAD = const(58)  # 4 Q12: the force it should have
C_PRINT = const(62)  # 2 sides (right, left) x 4 x 3 lf: footholds to come of the hind foot
C_PRINTS = const(86)  # 2: how many
C_ON_PRINT = const(88)  # 2: 1 = the last print is under the standing front foot
# The body's plan
C_REF = const(90)  # 6: the pose wanted now
C_FROM = const(96)  # 6: where its move began
C_TO = const(102)  # 6: where it ends
C_LAGGED = const(108)  # 6: the pose wanted, as late as the servos are
C_INTEGRAL = const(114)  # 6
C_CMD = const(120)  # 6: the pose commanded to the stance legs
C_LOW = const(126)  # 6: measured less wanted pose, smoothed
C_BODY_TICK = const(132)
C_BODY_TICKS = const(133)
C_WARP = const(134)  # lf, of one diagonal against the other
C_WEIGHT = const(135)  # Q12, weight carried, payload included
C_HEAVY = const(136)  # Q12, 0 = empty .. 4096 from 0.65 of the own weight on
# The legs' goals
C_OFFSET = const(137)  # 12 bf: what is left of the jump where stance and swing meet
C_GOAL = const(149)  # 12 brad: goals of the tick before
C_CLIPPED = const(161)  # 1: the swing leg was limited
# The machine
C_PHASE = const(162)
C_TICK = const(163)  # ticks of the phase
C_TURN = const(164)  # place in the order of the legs
C_LEG = const(165)  # the leg it is about
C_PACE = const(166)  # lf, how far the command is ahead of the steps made
# The swing
C_POS = const(167)  # 3 lf: where the foot is wanted
C_SOURCE = const(170)  # 2 lf: where its move began
C_TARGET = const(172)  # 3 lf: the foothold aimed at
C_EXPECT = const(175)  # lf: expected height of the ground there
C_TOP = const(176)  # lf
C_SPEED = const(177)  # lf / tick
C_MOVE_TICKS = const(178)
C_TRIES = const(179)
C_HITS = const(180)
C_DROPPED = const(181)  # 1: this swing has met a drop
C_LENGTH = const(182)  # lu, hip to foot in the leg's plane, before any limit
C_TARE = const(183)  # Q12
C_TOUCHED = const(184)  # ticks of load in a row
C_PEAK = const(185)  # 1: with more than the touch's force in one of them
C_PAST = const(186)  # 32 lf: x of C_POS in the ticks before
C_PAST_AT = const(218)
PAST_SIZE = const(32)
# What to tell
C_EVENT = const(219)  # code of the last event
C_EVENT_LEG = const(220)
C_EVENT_X = const(221)  # lu in the map
C_EVENT_Z = const(222)  # lu off the expected height
C_EVENTS = const(223)  # how many so far: a change is news
C_EVEN = const(224)  # lu, farthest spread of the footholds' heights in the last stride
C_LANDED = const(225)  # legs landed since the start
C_STEPS_EVEN = const(226)  # legs landed in a row on even footholds
C_MARGIN = const(227)  # lu, centre of mass inside the support
C_WEIGHT_FINE = const(228)  # Q20, the same as C_WEIGHT
C_SIZE = const(240)

SHIFT = const(0)  # all feet down, the body moves off the leg to come
LIFT = const(1)
MOVE = const(2)
TARE = const(3)  # the foot hangs: what its joints feel is no load
DOWN = const(4)
REST = const(5)  # all feet down, nothing to do

EVENT_NONE = const(0)
EVENT_LANDED = const(1)
EVENT_HIGH = const(2)  # ground higher than expected: another try further on
EVENT_VOID = const(3)  # no ground where it was expected: another try further out
EVENT_SHIN = const(4)  # the shin, not the foot, stands on an edge
EVENT_HIT = const(5)  # the foot ran into a riser
EVENT_NOTHING = const(6)  # no ground at all: the foot is left hanging
EVENT_WARP = const(7)  # the loads of the diagonals could not be brought to what was wanted
