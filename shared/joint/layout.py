"""The records of a joint: what the current step works on, what the host sets, what the joint remembers and is told.

Units: ``count`` ADC count. ``cu`` current, 1/6 count of the shunt amplifier. ``vu`` voltage, 2^-V_SHIFT V, one shift
per motor. ``rc`` rotor count, 1/16384 rotor turn. ``rate`` rc/256 per millisecond. ``t16`` temperature, 1/16 degree C.
``brad`` 1/65536 turn. Ticks are milliseconds, slow ticks a tenth of a second. Set-points come in the wire's units
(docs/can-protocol.md): position brad, velocity 1/4096 turn/s, current 1/4096 A.
"Joint-signed" quantities grow with the joint angle; the others with the encoder count.
"""

from ..record import field, record, vector
from ..runtime import Ints, const

SINE_SIZE = const(1280)
COSINE_AT = const(256)  # a quarter turn on in the table
WAVES = const(3)  # of the cogging that are held against
BENDS = const(33)  # of the rotor encoder's eccentricity, 32 a turn and the first once more


@record
class CurrentLoop:
    """What the current step works on. The first 32 places are the cheapest to reach: what every step needs is there."""

    raw: Ints = vector(3, "count", "phases a, b, c, written before each step; grow with current into the motor")
    rotor: int = field("rc", "last accepted rotor angle, 0 .. 16383")
    masked: int = field("", "bits 0 .. 2: phase a, b, c had no time to be sampled")
    reference_d: int = field("cu", "current wanted along the rotor's flux")
    reference_q: int = field("cu", "current wanted across it, positive turns towards growing electrical angle")
    cogging_q: int = field("cu", "current that holds against the cogging, added to reference_q (cogging.py)")
    feed_d: int = field("vu", "voltage fed forward on d")
    feed_q: int = field("vu", "voltage fed forward on q")
    limit_square: int = field("vu^2", "square of voltage_limit")
    gain_alpha: int = field("compare counts / vu", "modulator gain, Q14")
    gain_beta: int = field("compare counts / vu", "the same times sqrt(3)/2, Q14")
    offset_alpha: int = field("count", "2a - b - c at no current")
    offset_beta: int = field("", "(b - c) at no current times 28378, less 8192 for the rounding")
    electrical_gain: int = field("brad / rc", "+-4 x pole pairs; 0 while commissioning forces the angle")
    electrical_offset: int = field("brad", "with half a step of the sine table added and led by the reading's age")
    kp: int = field("vu / cu", "proportional gain, Q13")
    ki: int = field("vu / cu / step", "integral gain, Q13")
    half_period: int = field("1/16 compare count", "half the period plus rounding")
    span_max: int = field("1/16 compare count", "largest span of duties that leaves all pulses and samples alone")
    trip_square: int = field("cu^2", "square of the current at which the step trips")
    integral_d: int = field("vu", "integral term on d, Q13")
    integral_q: int = field("vu", "integral term on q, Q13")
    current_d: int = field("cu", "measured")
    current_q: int = field("cu", "measured")
    voltage_d: int = field("vu", "applied")
    voltage_q: int = field("vu", "applied")
    duty: Ints = vector(3, "compare counts", "phases a, b, c: time the high side is on, 0 .. period")
    glitches: int = field("", "rotor readings rejected since the last motion tick")
    limited_steps: int = field("", "steps with a limited voltage vector since the last motion tick")
    period: int = field("compare counts", "a whole period")
    voltage_limit: int = field("vu", "longest voltage vector: bus / sqrt 3")
    pulse: int = field("compare counts", "shortest pulse the bridge can make")
    window: int = field("compare counts", "time the low side must be on for a current sample")
    offset_q4: Ints = vector(3, "1/16 count", "readings of phases a, b, c at no current")
    tripped: int = field("", "1 after a trip, until the motion tick has taken it")
    rotor_rejected: int = field("rc", "last reading that was rejected but passed its check; -1 none")
    probing: int = field("", "1: the interrupt adds up what commissioning asks for (probe.py); 2, 3: a sine on d, q")
    probe_sign: int = field("", "+-1, of the sums")
    probe_steps: int = field("", "current steps added up")
    sum_current_d: int = field("cu", "")
    sum_current_q: int = field("cu", "")
    sum_voltage_d: int = field("vu", "")
    sum_voltage_q: int = field("vu", "")
    level: int = field("vu", "voltage on d about which it alternates")
    alternate_d: int = field("vu", "voltage on d that changes its sign at every step; 0 none")
    alternate_q: int = field("vu", "likewise on q")
    sine_at: int = field("brad", "of the sine that is added to the wanted current while commissioning (probe.py)")
    sine_add: int = field("brad / step", "by which it goes on")
    sine_current: int = field("cu", "its amplitude")
    level_current: int = field("cu", "current on d about which it swings")
    current_most: int = field("cu", "reference_q and cogging_q together stay within it")
    waves: int = field("", "of the cogging that act; 0 while the joint does not drive")
    wave_order: Ints = vector(WAVES, "", "of each: how often a turn, 0 none")
    wave_current: Ints = vector(WAVES, "cu", "of each: amplitude, Q4")
    wave_phase: Ints = vector(WAVES, "1/1024 wave", "of each: at the rotor's reading 0")
    bend: Ints = vector(BENDS, "rc", "to be added to the rotor encoder's reading at each 1/32 turn (bend.py)")
    sine: Ints = vector(SINE_SIZE, "", "Q15, the sine of each 1/1024 turn, and of a quarter turn more for the cosine")


@record
class LoopSettings:
    """What the current step is set to, in the order of the parameters current_kp .. trip_square."""

    current_kp: int = field("vu / cu", "proportional gain, Q13")
    current_ki: int = field("vu / cu / step", "integral gain, Q13")
    pwm_period: int = field("compare counts", "a whole period")
    pwm_half: int = field("1/16 compare count", "half the period plus rounding")
    pwm_span: int = field("1/16 compare count", "largest span of the duties")
    pwm_pulse: int = field("compare counts", "shortest pulse")
    pwm_window: int = field("compare counts", "time of a current sample")
    trip_square: int = field("cu^2", "square of the current at which the step trips")


@record
class JointSettings:
    """What host/robot/joint_gains.py sets once; commission may change what it found.

    Names and order are those of the parameters from pole_pairs on (host/protocol/parameters.toml).
    """

    # electrical
    pole_pairs: int = field("", "pole pairs of the motor")
    direction: int = field("", "+-1: electrical angle over rotor count")
    elec_offset: int = field("brad", "electrical angle at rotor count 0")
    commissioned: int = field("", "1: the three above were measured on this joint")
    bus_gain: int = field("vu / count", "of the bus voltage reading, Q12")
    bus_least: int = field("vu", "the modulator divides by no less")
    bemf: int = field("vu / (8 rate)", "back-EMF, Q16")
    omega_l: int = field("vu / (cu 8 rate)", "coupling of the axes; gives Q16 after >> 12")
    advance: int = field("brad / rate", "angle the rotor goes from the samples until the voltage acts, Q16")
    dead: int = field("", "dead-time voltage per bus voltage, Q15")
    dead_zone: int = field("cu", "below it the dead-time compensation fades out")
    # mechanics and encoders
    gear_q8: int = field("", "rotor turns per joint turn")
    joint_sign: int = field("", "+-1: joint angle over rotor count")
    zero: int = field("rc", "rotor count at joint angle 0")
    has_joint_encoder: int = field("", "1: the joint has its own encoder")
    joint_encoder_sign: int = field("", "+-1: joint angle over joint encoder count")
    joint_encoder_zero: int = field("1/16384 joint turn", "joint encoder reading at joint angle 0")
    disagree: int = field("rc", "largest difference of the encoders, below half a rotor turn")
    disagree_ticks: int = field("ticks", "for so long a larger one is a fault")
    track_1: int = field("", "Q12, tracking loop on the position")
    track_2: int = field("", "Q12, tracking loop on the velocity")
    glitch_steps: int = field("", "rejected rotor readings that make a millisecond bad")
    bad_ticks: int = field("ticks", "bad milliseconds that make a fault")
    home_tolerance: int = field("rc", "largest residual that homing accepts")
    # wire units
    rate_q8: int = field("", "rate per 1/4096 turn/s")
    wire_rate_q16: int = field("", "1/4096 turn/s per rate")
    current_q14: int = field("", "cu per 1/4096 A")
    wire_current_q12: int = field("", "1/4096 A per cu")
    turn18_q14: int = field("", "1/2^18 joint turn per rc")
    # cascade
    position_p: int = field("rate / rc", "position gain, Q6")
    velocity_p: int = field("cu / rate", "velocity gain, Q12")
    velocity_i: int = field("cu / rate / tick", "velocity integral gain, Q16")
    inertia: int = field("cu / (rate / tick)", "current per acceleration, Q8")
    rate_max: int = field("rate", "largest speed of the trajectory")
    accel: int = field("rate / tick", "largest acceleration of the trajectory")
    position_min: int = field("rc", "lower limit, joint-signed")
    position_max: int = field("rc", "upper limit, joint-signed")
    current_max: int = field("cu", "largest current asked for")
    damp: int = field("cu / rate", "damping after the watchdog, Q12")
    damp_current: int = field("cu", "largest current of that damping")
    extrapolate_ticks: int = field("ticks", "a moving target is followed that long without a new set-point")
    # protection
    under: int = field("vu", "bus voltage below which is a fault")
    over: int = field("vu", "bus voltage above which is a fault")
    under_start: int = field("vu", "driving current falls from here down to under")
    over_start: int = field("vu", "braking current falls from here up to over")
    bus_ticks: int = field("ticks", "for so long either is a fault")
    rate_trip: int = field("rate", "speed beyond which is a fault")
    position_margin: int = field("rc", "way beyond the position limits that is a fault")
    stall_rate: int = field("rate", "slower is standing")
    stall_ticks: int = field("ticks", "a stall that long is a fault")
    sum_limit: int = field("count", "largest sum of the phases")
    sum_ticks: int = field("ticks", "for so long a larger one is a fault")
    # thermal
    open_raw: int = field("count", "thermistor reading from here on is an open sensor")
    short_raw: int = field("count", "up to here a short")
    mcu_cal1: int = field("count", "factory reading of the microcontroller's sensor at 30 degrees C")
    mcu_cal2: int = field("count", "at 110")
    winding_derate: int = field("t16", "winding temperature from which the current falls")
    winding_cut: int = field("t16", "winding temperature where it is 0, a fault")
    mcu_derate: int = field("t16", "microcontroller's temperature from which the current falls")
    mcu_cut: int = field("t16", "microcontroller's temperature where it is 0, a fault")
    heat: int = field("t16/2^14 / slow tick / (cu^2/256)", "heating of the winding, times 2^heat_shift")
    winding_leak: int = field("", "share of the difference per slow tick that the winding loses, times 2^leak_shift")
    housing_gain: int = field("", "the same that the housing takes")
    housing_leak: int = field("", "the same that the housing loses to the air")
    i2t_current: int = field("cu", "may flow for ever")
    i2t_max: int = field("cu^2/256 x slow ticks", "i2t at which no more than that may flow")
    # states
    watchdog_ticks: int = field("ticks", "a set-point older than that is a fault")
    fresh_ticks: int = field("ticks", "arming needs a set-point at most that old")
    near: int = field("rc", "and at most that far away")
    damp_ticks: int = field("ticks", "a fault damps for so long")
    quick_ticks: int = field("ticks", "a quick stop damps for at most so long")
    # homing against the stop
    stop: int = field("rc", "position of the stop, joint-signed")
    home_rate: int = field("rate", "speed of the search, signed towards the stop")
    home_current: int = field("cu", "largest current of the search")
    home_ticks: int = field("ticks", "standing that long is the stop")
    home_limit_ticks: int = field("ticks", "give up after")
    # what came later
    heat_shift: int = field("", "of heat, 0 .. 24")
    leak_shift: int = field("", "of the leaks, 13 .. 30")
    offset_spread: int = field("count", "largest distance of a current offset from the middle")
    commission_current: int = field("cu", "on d while the field turns the rotor")
    commission_bus_least: int = field("vu", "bus voltage that commission needs at least")
    commission_bus_most: int = field("vu", "and at most")
    verify: int = field("brad", "largest change of the electrical offset that verifying accepts")
    wire_bus_q12: int = field("", "1/16 V per vu")
    age: int = field("brad / rate", "angle the rotor goes from its reading until the samples, Q16")
    current_w: int = field("rad / step", "bandwidth of the current loop that commissioning sets, Q12")
    bend_cos1: int = field("rc", "eccentricity of the rotor encoder, what to add: once a turn, Q4")
    bend_sin1: int = field("rc", "likewise")
    bend_cos2: int = field("rc", "twice a turn, Q4")
    bend_sin2: int = field("rc", "likewise")
    velocity_w: int = field("rad / tick", "bandwidth of the velocity loop that commissioning sets, Q16")
    cogging_order_0: int = field("", "first wave of the cogging: how often a turn, 0 none")
    cogging_current_0: int = field("cu", "its amplitude, Q4")
    cogging_phase_0: int = field("brad", "of the wave, at the rotor's reading 0")
    cogging_order_1: int = field("", "likewise the second wave")
    cogging_current_1: int = field("cu", "likewise")
    cogging_phase_1: int = field("brad", "likewise")
    cogging_order_2: int = field("", "likewise the third wave")
    cogging_current_2: int = field("cu", "likewise")
    cogging_phase_2: int = field("brad", "likewise")


@record
class JointIo:
    """What the joint is told (the application copies the latched set-point) and what its sensors read."""

    position: int = field("brad", "set-point")
    velocity: int = field("1/4096 turn/s", "set-point, or feed-forward")
    current: int = field("1/4096 A", "set-point, or feed-forward")
    stiffness: int = field("1/16 A/turn", "of the impedance, 0 .. 32767")
    damping: int = field("1/256 A/(turn/s)", "of the impedance, 0 .. 32767")
    mode: int = field("", "MODE_* of the set-point")
    sequence: int = field("", "any change means: a new set-point was accepted")
    hash_ok: int = field("", "1: the host speaks this protocol")
    session: int = field("", "session of the host, 0 none")
    e_stop: int = field("", "1 while an emergency stop is asked for")
    hardware_ready: int = field("", "1: driver set up and read back, sensors answer")
    hardware_fault: int = field("", "FAULT_* that the application found, 0 none")
    hardware_value: int = field("", "in the unit of that fault")
    bus_raw: int = field("count", "bus voltage")
    joint_raw: int = field("1/16384 joint turn", "joint encoder")
    joint_valid: int = field("", "1: the joint encoder's reading passed its check")
    thermistor_raw: int = field("count", "the winding's thermistor")
    mcu_raw: int = field("count", "the microcontroller's temperature sensor")


@record
class JointState:
    """What the joint remembers from tick to tick."""

    # encoders
    turns: int = field("rotor turns", "+-(2^30 - 2)")
    fraction: int = field("rc", "rotor angle within the turn, 0 .. 16383")
    position: int = field("rc", "from joint zero, joint-signed")
    velocity: int = field("rate", "joint-signed")
    lag: int = field("rc/256", "tracking loop behind the encoder")
    rate: int = field("rate", "encoder-signed")
    bad_ticks: int = field("ticks", "bad milliseconds less good ones")
    homed: int = field("", "1: turns is absolute")
    disagree_ticks: int = field("ticks", "that the encoders have disagreed")
    joint_error: int = field("rc", "joint encoder minus rotor")
    # cascade
    target: int = field("rc/256", "what the trajectory follows: glides to goal_position")
    target_age: int = field("ticks", "since it came")
    profile: int = field("rc/256", "position of the limited trajectory")
    profile_rate: int = field("rate", "speed of the limited trajectory")
    rate_reference: int = field("rate", "wanted of the velocity loop")
    current_reference: int = field("cu", "wanted of the current step, joint-signed")
    velocity_integral: int = field("cu", "of the velocity loop, Q12")
    mode: int = field("", "MODE_* in use")
    limits: int = field("", "LIMIT_* acting in this tick")
    current_limit: int = field("cu", "after derating")
    seen_sequence: int = field("", "of the set-point the cascade works on")
    # protection and thermal
    bus: int = field("vu", "bus voltage")
    under_ticks: int = field("ticks", "that it has been too low")
    over_ticks: int = field("ticks", "that it has been too high")
    stall_ticks: int = field("ticks", "that the joint has stalled")
    sum_ticks: int = field("ticks", "that the sum of the phases has been too large")
    winding: int = field("t16", "the hotter of sensor and model")
    mcu: int = field("t16", "microcontroller")
    model_winding: int = field("t16/2^14", "winding above the air in the model")
    model_housing: int = field("t16/2^14", "housing above the air in the model")
    air: int = field("t16", "air the model starts from")
    i2t: int = field("cu^2/256 x slow ticks", "current squared over time beyond the lasting one's")
    heat_sum: int = field("cu^2/256", "sum over the motion ticks since the last slow tick")
    heat_ticks: int = field("ticks", "how many these were")
    derate: int = field("", "Q15, share of the current limit that is left")
    slow_limits: int = field("", "LIMIT_* found by the slow tick")
    slow_cause: int = field("", "FAULT_* found by the slow tick, 0 none")
    slow_value: int = field("", "in the unit of that fault")
    thermal_started: int = field("", "1 once the model has its air temperature")
    # states of the drive
    drive_state: int = field("", "STATE_*")
    torque: int = field("", "TORQUE_*")
    request: int = field("", "REQUEST_*")
    purpose: int = field("", "MODE_* asked for with arm")
    time_ms: int = field("ms", "since the start, 0 .. 2^30 - 1, then again 0")
    cause: int = field("", "FAULT_* present in this tick, the first found")
    cause_value: int = field("", "in the unit of that fault")
    fault_code: int = field("", "latched first cause")
    fault_value: int = field("", "its value")
    fault_tick: int = field("ms", "time at which it was latched")
    setpoint_age: int = field("ticks", "since the last set-point")
    sequence: int = field("", "of the last set-point seen")
    reaction_ticks: int = field("ticks", "in fault reaction or quick stop")
    range_exceeded: int = field("", "1: this motion tick took position over the end of its range")
    # homing
    home_ticks: int = field("ticks", "that the search has lasted")
    home_still_ticks: int = field("ticks", "that the joint has pushed at rest")
    home_result: int = field("", "HOME_*")
    home_rate: int = field("rate", "speed the search asks for")
    raised: int = field("", "FAULT_* raised by homing or commission, taken by the next tick")
    raised_value: int = field("", "in the unit of that fault")
    # more of the cascade
    acceleration_feed: int = field("cu", "the acceleration's smoothed share of the current, Q4")
    goal_position: int = field("rc/256", "where the last set-point and its velocity say that the joint should be")
    target_rate: int = field("rate", "of target, on its way to the set-point's velocity")
    target_ticks_left: int = field("ticks", "until target is goal_position")


TORQUE_OFF = const(0)  # bridge off, the joint coasts
TORQUE_DAMP = const(1)  # only against the motion, no set-point
TORQUE_DRIVE = const(2)  # what the set-points ask for
