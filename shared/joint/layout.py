"""The four blocks of a joint, each one array('i') with named places, and their units.

``foc`` is what the current step works on, ``cfg`` is set once by the host (host/joint_gains.py is
its only writer; calibration may change what it found), ``state`` is what the joint remembers,
``io`` is what it is told and what its sensors read.

Units: ``count`` ADC count. ``cu`` current, 1/6 count of the shunt amplifier. ``vu`` voltage,
2^-V_SHIFT V, one shift per motor. ``rc`` rotor count, 1/16384 rotor turn. ``rate`` rc/256 per
millisecond. ``t16`` temperature, 1/16 degree C. ``brad`` 1/65536 turn. The wire's units (docs/can-protocol.md) are
used in ``io`` for set-points: position brad, velocity 1/4096 turn/s, current 1/4096 A.
"Joint-signed" quantities grow with the joint angle; the others with the encoder count.
"""

from ..runtime import const

# foc: the first 32 places are cheapest to reach, so what every step needs comes first
F_RAW_A = const(0)  # count, written before each step; grows with current into the motor
F_RAW_B = const(1)
F_RAW_C = const(2)
F_ROTOR = const(3)  # rc 0 .. 16383, last accepted rotor angle
F_MASKED = const(4)  # bits 0 .. 2: phase a, b, c had no time to be sampled
F_D_REF = const(5)  # cu
F_Q_REF = const(6)  # cu, positive turns towards growing electrical angle
F_FEED_D = const(7)  # vu, feed-forward
F_FEED_Q = const(8)
F_LIMIT_SQUARE = const(9)  # vu^2, square of F_LIMIT
F_GAIN_ALPHA = const(10)  # compare counts per vu, Q14
F_GAIN_BETA = const(11)  # the same times sqrt(3)/2
F_OFFSET_ALPHA = const(12)  # count, 2a - b - c at no current
F_OFFSET_BETA = const(13)  # (b - c) at no current times 28378, less 8192 for the rounding
F_ELEC_GAIN = const(14)  # brad per rc: +-4 x pole pairs; 0 while calibration forces the angle
F_ELEC_OFFSET = const(15)  # brad, with half a step of the sine table added and led by the reading's age
F_KP = const(16)  # vu per cu, Q13
F_KI = const(17)  # vu per cu and step, Q13
F_HALF = const(18)  # 1/16 compare count, half the period plus rounding
F_SPAN = const(19)  # 1/16 compare count, largest span that leaves all pulses and samples alone
F_TRIP_SQUARE = const(20)  # cu^2
F_INTEGRAL_D = const(21)  # vu, Q13
F_INTEGRAL_Q = const(22)
F_I_D = const(23)  # cu, measured
F_I_Q = const(24)
F_V_D = const(25)  # vu, applied
F_V_Q = const(26)
F_DUTY_A = const(27)  # compare counts 0 .. F_PERIOD: time the high side is on
F_DUTY_B = const(28)
F_DUTY_C = const(29)
F_GLITCHES = const(30)  # rotor readings rejected since the last motion tick
F_LIMITED = const(31)  # steps with a limited voltage vector since the last motion tick
F_PERIOD = const(32)  # compare counts of a whole period
F_LIMIT = const(33)  # vu, longest voltage vector: bus / sqrt 3
F_PULSE = const(34)  # compare counts, shortest pulse the bridge can make
F_WINDOW = const(35)  # compare counts the low side must be on for a current sample
F_OFFSET_A = const(36)  # 1/16 count at no current
F_OFFSET_B = const(37)
F_OFFSET_C = const(38)
F_TRIPPED = const(39)  # 1 after a trip, until the motion tick has taken it
F_ROTOR_SEEN = const(40)  # rc, last reading that was rejected but passed its check; -1 none
F_SINE = const(41)  # Q15, the sine of each 1/1024 turn from here on (sine.py)
F_COSINE = const(297)  # the same a quarter turn ahead
FOC_SIZE = const(1321)

# cfg: electrical
K_POLE_PAIRS = const(0)
K_DIRECTION = const(1)  # +-1: electrical angle over rotor count
K_ELEC_OFFSET = const(2)  # brad, electrical angle at rotor count 0
K_CALIBRATED = const(3)  # 1: the three above were measured on this joint
K_BUS_GAIN = const(4)  # vu per count of the bus voltage, Q12
K_BUS_LEAST = const(5)  # vu, the modulator divides by no less
K_BEMF = const(6)  # vu per rate/8, Q16
K_OMEGA_L = const(7)  # vu per cu and rate/8: gives Q16 after >> 12
K_ADVANCE = const(8)  # brad per rate, Q16: angle the rotor goes from the samples until the voltage acts
K_DEAD = const(9)  # dead-time voltage per bus voltage, Q15
K_DEAD_ZONE = const(10)  # cu, below it the compensation fades out
# cfg: mechanics and encoders
K_GEAR_Q8 = const(11)  # rotor turns per joint turn
K_JOINT_SIGN = const(12)  # +-1: joint angle over rotor count
K_ZERO = const(13)  # rc, rotor count at joint angle 0
K_HAS_JOINT_ENCODER = const(14)
K_JOINT_ENCODER_SIGN = const(15)  # +-1: joint angle over joint encoder count
K_JOINT_ENCODER_ZERO = const(16)  # 1/16384 joint turn at joint angle 0
K_DISAGREE = const(17)  # rc, below half a rotor turn
K_DISAGREE_TICKS = const(18)
K_TRACK_1 = const(19)  # Q12, tracking loop on the position
K_TRACK_2 = const(20)  # Q12, on the velocity
K_GLITCH_STEPS = const(21)  # rejected readings that make a millisecond bad
K_BAD_TICKS = const(22)  # bad milliseconds that make a fault
K_HOME_TOLERANCE = const(23)  # rc, largest residual that homing accepts
# cfg: wire units
K_RATE_Q8 = const(24)  # rate per 1/4096 turn/s
K_WIRE_RATE_Q16 = const(25)  # 1/4096 turn/s per rate
K_CURRENT_Q14 = const(26)  # cu per 1/4096 A
K_WIRE_CURRENT_Q12 = const(27)  # 1/4096 A per cu
K_TURN18_Q14 = const(28)  # 1/2^18 joint turn per rc
# cfg: cascade
K_POSITION_P = const(29)  # rate per rc, Q6
K_VELOCITY_P = const(30)  # cu per rate, Q12
K_VELOCITY_I = const(31)  # cu per rate and tick, Q16
K_INERTIA = const(32)  # cu per rate/tick, Q8
K_RATE_MAX = const(33)  # rate
K_ACCEL = const(34)  # rate per tick
K_POSITION_MIN = const(35)  # rc, joint-signed
K_POSITION_MAX = const(36)
K_CURRENT_MAX = const(37)  # cu
K_DAMP = const(38)  # cu per rate, Q12, after the watchdog
K_DAMP_CURRENT = const(39)  # cu
K_EXTRAPOLATE_TICKS = const(40)  # a moving target is followed that long without a new set-point
# cfg: protection
K_UNDER = const(41)  # vu
K_OVER = const(42)
K_UNDER_START = const(43)  # vu, driving current falls from here down to K_UNDER
K_OVER_START = const(44)  # vu, braking current falls from here up to K_OVER
K_BUS_TICKS = const(45)
K_RATE_TRIP = const(46)  # rate
K_POSITION_MARGIN = const(47)  # rc beyond the limits that is a fault
K_STALL_RATE = const(48)  # rate, slower is standing
K_STALL_TICKS = const(49)
K_SUM_LIMIT = const(50)  # count
K_SUM_TICKS = const(51)
# cfg: thermal
K_OPEN_RAW = const(52)  # count, thermistor reading from here on is an open sensor
K_SHORT_RAW = const(53)  # count, up to here a short
K_MCU_CAL1 = const(54)  # factory reading at 30 degrees C
K_MCU_CAL2 = const(55)  # at 110
K_WINDING_DERATE = const(56)  # t16
K_WINDING_CUT = const(57)
K_MCU_DERATE = const(58)
K_MCU_CUT = const(59)
K_HEAT = const(60)  # t16/2^14 per slow tick and cu^2/256, times 2^K_HEAT_SHIFT
K_WINDING_LEAK = const(61)  # share of the difference per slow tick, times 2^K_LEAK_SHIFT: seen by the winding
K_HOUSING_GAIN = const(62)  # the same seen by the housing
K_HOUSING_LEAK = const(63)  # to the air
K_I2T_CURRENT = const(64)  # cu, may flow for ever
K_I2T_MAX = const(65)  # cu^2/256 x slow ticks
# cfg: states
K_WATCHDOG_TICKS = const(66)
K_FRESH_TICKS = const(67)  # arming needs a set-point at most that old
K_NEAR = const(68)  # rc, and at most that far away
K_DAMP_TICKS = const(69)
K_QUICK_TICKS = const(70)
# cfg: homing against the stop
K_STOP = const(71)  # rc, joint-signed position of the stop
K_HOME_RATE = const(72)  # rate, signed towards the stop
K_HOME_CURRENT = const(73)  # cu
K_HOME_TICKS = const(74)  # standing that long at the stop
K_HOME_LIMIT_TICKS = const(75)  # give up after
K_HEAT_SHIFT = const(76)
K_LEAK_SHIFT = const(77)
K_OFFSET_SPREAD = const(78)  # count, largest distance of a current offset from the middle
K_CAL_CURRENT = const(79)  # cu on d while the field turns the rotor
K_CAL_BUS_LEAST = const(80)  # vu
K_CAL_BUS_MOST = const(81)
K_VERIFY = const(82)  # brad, largest change of the electrical offset that verifying accepts
K_WIRE_BUS_Q12 = const(83)  # 1/16 V per vu
K_AGE = const(84)  # brad per rate, Q16: angle the rotor goes from its reading until the samples
CFG_SIZE = const(85)

# io: what the joint is told (the application copies the latched set-point) and what is read
IO_POSITION = const(0)  # brad
IO_VELOCITY = const(1)  # 1/4096 turn/s: set-point, or feed-forward
IO_CURRENT = const(2)  # 1/4096 A: set-point, or feed-forward
IO_STIFFNESS = const(3)  # 1/16 A/turn
IO_DAMPING = const(4)  # 1/256 A/(turn/s)
IO_MODE = const(5)  # MODE_* of the set-point
IO_SEQUENCE = const(6)  # any change means: a new set-point was accepted
IO_HASH_OK = const(7)  # 1: the host speaks this protocol
IO_SESSION = const(8)  # session of the host, 0 none
IO_E_STOP = const(9)  # 1 while an emergency stop is asked for
IO_HARDWARE_READY = const(10)  # 1: driver set up and read back, sensors answer
IO_HARDWARE_FAULT = const(11)  # FAULT_* that the application found, 0 none
IO_HARDWARE_VALUE = const(12)
IO_BUS_RAW = const(13)  # count
IO_JOINT_RAW = const(14)  # 1/16384 joint turn
IO_JOINT_VALID = const(15)
IO_THERMISTOR_RAW = const(16)  # count
IO_MCU_RAW = const(17)  # count
IO_SIZE = const(18)

# state: encoders
S_TURNS = const(0)  # rotor turns, +-(2^30 - 2)
S_FRACTION = const(1)  # rc 0 .. 16383
S_POSITION = const(2)  # rc, joint-signed, from joint zero
S_VELOCITY = const(3)  # rate, joint-signed
S_LAG = const(4)  # rc/256, tracking loop behind the encoder
S_RATE = const(5)  # rate, encoder-signed
S_BAD_TICKS = const(6)
S_HOMED = const(7)  # 1: S_TURNS is absolute
S_DISAGREE_TICKS = const(8)
S_JOINT_ERROR = const(9)  # rc, joint encoder minus rotor
# state: cascade
S_TARGET = const(10)  # rc/256, what the trajectory follows: glides to S_GOAL
S_TARGET_AGE = const(11)  # ticks since it came
S_PROFILE = const(12)  # rc/256, limited trajectory
S_PROFILE_RATE = const(13)  # rate
S_RATE_REF = const(14)  # rate
S_CURRENT_REF = const(15)  # cu, joint-signed
S_V_INTEGRAL = const(16)  # cu, Q12
S_MODE = const(17)  # MODE_* in use
S_LIMITS = const(18)  # LIMIT_* acting in this tick
S_CURRENT_LIMIT = const(19)  # cu, after derating
S_SEEN_SEQUENCE = const(20)  # of the set-point the cascade works on
# state: protection and thermal
S_BUS = const(21)  # vu
S_UNDER_TICKS = const(22)
S_OVER_TICKS = const(23)
S_STALL_TICKS = const(24)
S_SUM_TICKS = const(25)
S_WINDING = const(26)  # t16, the hotter of sensor and model
S_MCU = const(27)  # t16
S_MODEL_WINDING = const(28)  # t16/2^14 above the air
S_MODEL_HOUSING = const(29)
S_AIR = const(30)  # t16, air the model starts from
S_I2T = const(31)  # cu^2/256 x slow ticks
S_HEAT_SUM = const(32)  # cu^2/256 over motion ticks since the last slow tick
S_HEAT_TICKS = const(33)
S_DERATE = const(34)  # Q15, share of the current limit that is left
S_SLOW_LIMITS = const(35)  # LIMIT_* found by the slow tick
S_SLOW_CAUSE = const(36)  # FAULT_* found by the slow tick, 0 none
S_SLOW_VALUE = const(37)
S_THERMAL_STARTED = const(38)
# state: drive
S_DRIVE = const(39)  # STATE_*
S_TORQUE = const(40)  # TORQUE_*
S_REQUEST = const(41)  # REQUEST_*
S_PURPOSE = const(42)  # MODE_* asked for with arm
S_TICK = const(43)  # ms, 0 .. 2^30 - 1, then again 0
S_CAUSE = const(44)  # FAULT_* present in this tick, the first found
S_CAUSE_VALUE = const(45)
S_FAULT_CODE = const(46)  # latched first cause
S_FAULT_VALUE = const(47)
S_FAULT_TICK = const(48)
S_SETPOINT_AGE = const(49)  # ticks
S_SEQUENCE = const(50)
S_REACTION_TICKS = const(51)
S_SHIFTED = const(52)  # 1: this motion tick took S_POSITION over the end of its range
# state: homing
S_HOME_TICKS = const(53)
S_HOME_STILL = const(54)
S_HOME_RESULT = const(55)  # HOME_*
S_HOME_RATE = const(56)  # rate the search asks for
S_RAISED = const(57)  # FAULT_* raised by homing or calibration, taken by the next tick
S_RAISED_VALUE = const(58)
S_ACCEL_FEED = const(59)  # cu, Q4, the acceleration's smoothed share of the current
S_GOAL = const(60)  # rc/256, where the last set-point and its velocity say that the joint should be by now
S_TARGET_RATE = const(61)  # rate, on its way to the set-point's velocity
S_TARGET_LEFT = const(62)  # ticks until S_TARGET is S_GOAL
STATE_SIZE = const(63)

TORQUE_OFF = const(0)  # bridge off, the joint coasts
TORQUE_DAMP = const(1)  # only against the motion, no set-point
TORQUE_DRIVE = const(2)  # what the set-points ask for

REQUEST_NONE = const(0)
REQUEST_ARM = const(1)
REQUEST_DISARM = const(2)
REQUEST_QUICK_STOP = const(3)
REQUEST_CLEAR = const(4)

HOME_IDLE = const(0)
HOME_SEEKING = const(1)
HOME_DONE = const(2)
HOME_NO_STOP = const(3)
HOME_AMBIGUOUS = const(4)
