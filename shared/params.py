"""The robot as one block of integers: what the host fills in and the core reads.

``host/scale.py`` is the only writer. Units: ``lu`` is the robot's length unit, 2^-LENGTH_SHIFT m;
``lf`` is lu/256, used where small steps add up; ``brad`` is 1/65536 turn; ``yaw18`` is
2^-18 rad. Speeds are per tick of the planner, so a block belongs to one rate.
"""

from .runtime import const

LEGS = const(4)
JOINTS = const(12)
FR = const(0)
FL = const(1)
RR = const(2)
RL = const(3)

# The whole robot
P_RATE_HZ = const(0)  # planner ticks a second, 20 .. 500
P_LENGTH_SHIFT = const(1)  # lu = 2^-shift m
P_VX_MAX = const(2)  # lf / tick
P_VY_MAX = const(3)
P_WZ_MAX = const(4)  # yaw18 / tick
P_VX_SLEW = const(5)  # lf / tick^2
P_VY_SLEW = const(6)
P_WZ_SLEW = const(7)  # yaw18 / tick^2
P_POSE_MAX = const(8)  # 6 values: x, y, z in lu; roll, pitch, yaw in brad
P_POSE_SLEW = const(14)  # 6 values, per tick
P_JOINT_STEP = const(20)  # brad / tick, largest joint speed while rising and sitting down
P_SIT_Z = const(21)  # lu, foot below the hip when seated (negative)
P_KP_Q12 = const(22)  # balance: proportional gain
P_KI_Q16 = const(23)  # balance: integral gain times the tick
P_KD_Q10 = const(24)  # balance: derivative gain over the tick
P_INTEGRAL_MAX = const(25)  # brad, limit of the integral term
P_BALANCE_MAX = const(26)  # brad, limit of roll and pitch correction together
P_STRIDE_MAX = const(27)  # lu, longest way of a foot along the ground in one stance
P_BALANCE_ON = const(28)  # 1: balance acts unless the command says otherwise
P_JOINT_TOP = const(29)  # 3 values: hip, thigh, calf; brad / tick, the fastest the motor turns its joint
P_SIZE_BODY = const(32)  # the legs follow

# One leg, at P_SIZE_BODY + leg * LEG_SIZE
LEG_SIDE_L1 = const(0)  # lu, hip offset, + left, - right
LEG_L2 = const(1)  # lu, thigh
LEG_L3 = const(2)  # lu, calf
LEG_KNEE = const(3)  # -1 knee behind the hip (elbow), +1 in front (knee)
LEG_REACH = const(4)  # lu, floor of the longest hip-foot distance
LEG_NEAR = const(5)  # lu, ceiling of the shortest
LEG_OUTER_SQ = const(6)  # (L2 + L3)^2
LEG_INNER_SQ = const(7)  # (L2 - L3)^2
LEG_HALF_DIFF = const(8)  # (L2^2 - L3^2) / 2
LEG_MIN = const(9)  # 3 values: lowest hip, thigh, calf angle, brad
LEG_MAX = const(12)  # 3 values: highest
LEG_HIP = const(15)  # 3 values: the hip in the body, lu
LEG_REST = const(18)  # 3 values: the foot in the body at rest, lu
LEG_CLEAR = const(21)  # lu, the highest a foot is put, from its hip (negative); only in the crawl's limbs
LEG_SIZE = const(24)

# How the joints give, and how the robot's own mass lies; after the legs, at P_SIZE_BODY + LEGS * LEG_SIZE
P_SAG_Q16 = const(128)  # 3 values: hip, thigh, calf; brad of sag that is fed forward, per lu of lever at own weight
P_STIFF_Q8 = const(131)  # 3 values: own weight times lu, per brad of joint error
P_DAMP_Q8 = const(134)  # 3 values: own weight times lu, per brad a tick of joint speed
P_COUPLED = const(137)  # 1: the calf's motor is on the body and sets thigh + calf (paper B)
P_SAGS = const(138)  # 1: the joints give under load, so their error tells the load
P_COM_X = const(139)  # lu, centre of mass in the body at rest
P_COM_Y = const(140)  # lu
P_FOOT_RADIUS = const(141)  # lu
P_SENT_TICKS = const(142)  # age of the goals that the measured joints answer, ticks, 0 .. 15
P_LOAD_SLEW_Q12 = const(143)  # of the own weight, per tick: how fast a foot's expected load moves
P_LEG_LENGTH = const(144)  # lu, thigh + calf of leg FR
P_LATERAL_Q12 = const(145)  # share of the sideways shift over the support, 0 in the plane
# The adaptive trot
P_RAISE = const(146)  # lu, body above the rest height
P_FORWARD = const(147)  # lu, body ahead of the feet
P_LEG_LONGEST = const(148)  # lu, hip to foot in the leg's plane, beyond which the body crouches
P_HEIGHT_SLEW = const(149)  # lu / tick upwards; twice as fast downwards
P_START_SPEED = const(150)  # lf / tick, the fastest of the first step
P_START_SLEW = const(151)  # lf / tick^2, how the fastest grows
P_SLOW_SPEED = const(152)  # lf / tick, up to which the segments have their slow lengths
P_FAST_SPEED = const(153)  # lf / tick, from which they have their fast ones
P_BODY_SLOW = const(154)  # ticks on four feet
P_BODY_FAST = const(155)
P_SWING_SLOW = const(156)  # ticks on two feet
P_SWING_FAST = const(157)
P_STAND_TICKS = const(158)  # from a foot's planned touchdown until it surely stands
P_TIP_TICKS = const(159)  # from a goal to its effect on the attitude
P_LOAD_GAIN_Q15 = const(160)  # per tick, of the measured weight
P_WARP_GAIN_Q15 = const(161)  # per tick, of the ground's twist
P_PRESS = const(162)  # lu / tick, how fast a foothold's height is corrected
P_HOLD_Q16 = const(163)  # speed per error, ticks^-1: position and heading
P_OWN_KP_Q12 = const(164)  # its balance: proportional gain
P_OWN_KI_Q16 = const(165)  # integral gain times the tick
P_OWN_KD_Q10 = const(166)  # derivative gain over the tick
P_ROUGH_DECAY_Q15 = const(167)  # per tick, of the remembered tilt
P_LATE_TICKS = const(168)  # lag behind the reference that is normal, ticks of the speed
P_SWAY_SLEW = const(169)  # lu / tick, back to the middle when standing
# Falling
P_TILT_MAX = const(170)  # brad, roll or pitch beyond which the robot has fallen
P_TILT_TICKS = const(171)  # for so long
P_ADVICE_TICKS = const(172)  # how long trouble lasts before another gait is advised
# What is believed
P_READ_STEP = const(173)  # brad, how far a joint's reading may be from the one before
P_TILT_STEP = const(174)  # brad, how far roll and pitch may be
P_JOINT_NEAR = const(175)  # brad / tick that every joint of a leg can turn, whatever the others do
P_SIZE = const(192)
LF_BITS = const(8)  # lf = lu / 2^8
