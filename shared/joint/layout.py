"""The records of a joint: the current step's data, the host's settings, the joint's inputs and its state.

Units: ``count`` ADC count. ``cu`` current, 1/6 count of the shunt amplifier. ``vu`` voltage, 2^-V_SHIFT V, one shift
per motor. ``rc`` rotor count, 1/16384 rotor turn. ``rate`` rc/256 per millisecond. ``t16`` temperature, 1/16 degree C.
``brad`` 1/65536 turn. Ticks are milliseconds, slow ticks a tenth of a second. Set-points come in the wire's units
(docs/can-protocol.md): position brad, velocity 1/4096 turn/s, current 1/4096 A. "Joint-signed" quantities grow with the
joint angle; the others with the encoder count.
"""

from ..record import field, record, vector
from ..runtime import Ints, const

SINE_SIZE = const(1280)
COSINE_AT = const(256)  # a quarter turn on in the table
WAVES = const(3)  # of the cogging that are compensated
BENDS = const(33)  # entries for the rotor encoder's eccentricity: 32 a turn, and the first again


@record
class CurrentLoop:
    """What the current step works on. The first 32 places are the cheapest to reach: what every step needs is there."""

    raw: Ints = vector(3, "count", "phases a, b, c, written before each step; grow with current into the motor")
    rotor: int = field("rc", "last accepted rotor angle, 0 .. 16383")
    masked: int = field("", "bits 0 .. 2: phase a, b, c had no time to be sampled")
    reference_d: int = field("cu", "current wanted along the rotor's flux")
    reference_q: int = field("cu", "current wanted across it, positive turns towards growing electrical angle")
    cogging_q: int = field("cu", "current that compensates the cogging, added to reference_q (cogging.py)")
    feed_d: int = field("vu", "voltage fed forward on d")
    feed_q: int = field("vu", "voltage fed forward on q")
    limit_square: int = field("vu^2", "square of voltage_limit")
    gain_alpha: int = field("compare counts / vu", "modulator gain, Q14")
    gain_beta: int = field("compare counts / vu", "the same times sqrt(3)/2, Q14")
    offset_alpha: int = field("count", "2a - b - c at no current")
    offset_beta: int = field("", "(b - c) at no current times 28378, less 8192 for the rounding")
    electrical_gain: int = field("brad / rc", "+-4 x pole pairs; 0 while commissioning forces the angle")
    electrical_offset: int = field("brad", "at count 0, plus half a step of the sine table, ahead by the reading's age")
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
    probe_sign: int = field("", "+-1, factor of the sums")
    probe_steps: int = field("", "current steps added up")
    sum_current_d: int = field("cu", "sum of current_d")
    sum_current_q: int = field("cu", "sum of current_q")
    sum_voltage_d: int = field("vu", "sum of voltage_d")
    sum_voltage_q: int = field("vu", "sum of voltage_q")
    level: int = field("vu", "voltage on d about which alternate_d alternates")
    alternate_d: int = field("vu", "voltage on d that changes its sign at every step; 0 none")
    alternate_q: int = field("vu", "likewise on q")
    sine_at: int = field("brad", "phase of the sine that is added to the wanted current in commissioning (probe.py)")
    sine_add: int = field("brad / step", "change of that phase")
    sine_current: int = field("cu", "its amplitude")
    level_current: int = field("cu", "current on d about which the sine swings")
    current_most: int = field("cu", "limit of reference_q and cogging_q together")
    waves: int = field("", "how many waves of the cogging act; 0 while the joint does not drive")
    wave_order: Ints = vector(WAVES, "", "of each: how often a turn, 0 none")
    wave_current: Ints = vector(WAVES, "cu", "of each: amplitude, Q4")
    wave_phase: Ints = vector(WAVES, "1/1024 wave", "of each: at the rotor's reading 0")
    bend: Ints = vector(BENDS, "rc", "correction of the rotor encoder's reading at each 1/32 turn (bend.py)")
    sine: Ints = vector(SINE_SIZE, "", "Q15, the sine of each 1/1024 turn, and of a quarter turn more for the cosine")


@record
class LoopSettings:
    """Settings of the current step, in the order of the parameters current_kp .. trip_square."""

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
    """Settings that host/robot/joint_gains.py computes; commissioning may change those that it measures.

    Names and order are those of the parameters from pole_pairs on (host/protocol/parameters.toml).
    """

    # electrical
    pole_pairs: int = field("", "pole pairs of the motor")
    direction: int = field("", "+-1: electrical angle over rotor count")
    elec_offset: int = field("brad", "electrical angle at rotor count 0")
    commissioned: int = field("", "1: the three above were measured on this joint")
    bus_gain: int = field("vu / count", "of the bus voltage reading, Q12")
    bus_least: int = field("vu", "lowest bus voltage by which the modulator divides")
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
    disagree_ticks: int = field("ticks", "a larger difference is a fault after this time")
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
    extrapolate_ticks: int = field("ticks", "a moving target is followed for this time without a new set-point")
    # protection
    under: int = field("vu", "a lower bus voltage is a fault")
    over: int = field("vu", "a higher bus voltage is a fault")
    under_start: int = field("vu", "driving current falls from here down to under")
    over_start: int = field("vu", "braking current falls from here up to over")
    bus_ticks: int = field("ticks", "either is a fault after this time")
    rate_trip: int = field("rate", "a higher speed is a fault")
    position_margin: int = field("rc", "farther beyond the position limits is a fault")
    stall_rate: int = field("rate", "a lower speed counts as standing")
    stall_ticks: int = field("ticks", "a stall is a fault after this time")
    sum_limit: int = field("count", "largest sum of the phases")
    sum_ticks: int = field("ticks", "a larger sum is a fault after this time")
    # thermal
    open_raw: int = field("count", "a thermistor reading from here up is an open sensor")
    short_raw: int = field("count", "a thermistor reading from here down is a short")
    mcu_cal1: int = field("count", "factory reading of the microcontroller's sensor at 30 degrees C")
    mcu_cal2: int = field("count", "its reading at 110 degrees C")
    winding_derate: int = field("t16", "winding temperature from which the current falls")
    winding_cut: int = field("t16", "winding temperature where it is 0, a fault")
    mcu_derate: int = field("t16", "microcontroller's temperature from which the current falls")
    mcu_cut: int = field("t16", "microcontroller's temperature where it is 0, a fault")
    heat: int = field("t16/2^14 / slow tick / (cu^2/256)", "heating of the winding, times 2^heat_shift")
    winding_leak: int = field("", "share of the difference per slow tick that the winding loses, times 2^leak_shift")
    housing_gain: int = field("", "the same share that the housing takes")
    housing_leak: int = field("", "the same share that the housing loses to the air")
    i2t_current: int = field("cu", "may flow without limit in time")
    i2t_max: int = field("cu^2/256 x slow ticks", "i2t from which on no more than i2t_current may flow")
    # states
    watchdog_ticks: int = field("ticks", "an older set-point is a fault")
    fresh_ticks: int = field("ticks", "arming needs a set-point no older than this")
    near: int = field("rc", "and no farther from the joint than this")
    damp_ticks: int = field("ticks", "a fault damps for this time")
    quick_ticks: int = field("ticks", "a quick stop damps for this time at most")
    # homing against the stop
    stop: int = field("rc", "position of the stop, joint-signed")
    home_rate: int = field("rate", "speed of the search, signed towards the stop")
    home_current: int = field("cu", "largest current of the search")
    home_ticks: int = field("ticks", "standing for this time is the stop")
    home_limit_ticks: int = field("ticks", "the search gives up after this time")
    # exponents of the heat
    heat_shift: int = field("", "of heat, 0 .. 24")
    leak_shift: int = field("", "of the leaks, 13 .. 30")
    # commissioning
    offset_spread: int = field("count", "largest distance of a current offset from the middle")
    commission_current: int = field("cu", "on d while the field turns the rotor")
    commission_bus_least: int = field("vu", "lowest bus voltage for commissioning")
    commission_bus_most: int = field("vu", "highest bus voltage for commissioning")
    verify: int = field("brad", "largest change of the electrical offset that verifying accepts")
    # units and timing
    wire_bus_q12: int = field("", "1/16 V per vu")
    age: int = field("brad / rate", "angle the rotor goes from its reading until the samples, Q16")
    # loops and the rotor encoder's eccentricity
    current_w: int = field("rad / step", "bandwidth of the current loop that commissioning sets, Q12")
    bend_cos1: int = field("rc", "correction of the rotor encoder's eccentricity: once a turn, Q4")
    bend_sin1: int = field("rc", "likewise")
    bend_cos2: int = field("rc", "twice a turn, Q4")
    bend_sin2: int = field("rc", "likewise")
    velocity_w: int = field("rad / tick", "bandwidth of the velocity loop that commissioning sets, Q16")
    # cogging
    cogging_order_0: int = field("", "first wave of the cogging: how often a turn, 0 none")
    cogging_current_0: int = field("cu", "its amplitude, Q4")
    cogging_phase_0: int = field("brad", "its phase at the rotor's reading 0")
    cogging_order_1: int = field("", "likewise the second wave")
    cogging_current_1: int = field("cu", "likewise")
    cogging_phase_1: int = field("brad", "likewise")
    cogging_order_2: int = field("", "likewise the third wave")
    cogging_current_2: int = field("cu", "likewise")
    cogging_phase_2: int = field("brad", "likewise")


@record
class JointIo:
    """The inputs of the joint: the set-point, copied by the application from the latched one, and sensor readings."""

    position: int = field("brad", "set-point")
    velocity: int = field("1/4096 turn/s", "set-point, or feed-forward")
    current: int = field("1/4096 A", "set-point, or feed-forward")
    stiffness: int = field("1/16 A/turn", "of the impedance, 0 .. 32767")
    damping: int = field("1/256 A/(turn/s)", "of the impedance, 0 .. 32767")
    mode: int = field("", "MODE_* of the set-point")
    sequence: int = field("", "changes with each accepted set-point")
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
    lag: int = field("rc/256", "position predicted by the tracking loop, less the encoder's")
    rate: int = field("rate", "encoder-signed")
    bad_ticks: int = field("ticks", "bad milliseconds less good ones")
    homed: int = field("", "1: turns is absolute")
    disagree_ticks: int = field("ticks", "for how long the encoders have disagreed")
    joint_error: int = field("rc", "joint encoder minus rotor")
    # cascade
    target: int = field("rc/256", "what the trajectory follows: glides to goal_position")
    target_age: int = field("ticks", "since the last set-point")
    goal_position: int = field("rc/256", "where the joint should be by the last set-point and its velocity")
    target_rate: int = field("rate", "rate of target, on its way to the set-point's velocity")
    target_ticks_left: int = field("ticks", "until target has reached goal_position")
    profile: int = field("rc/256", "position of the limited trajectory")
    profile_rate: int = field("rate", "speed of the limited trajectory")
    rate_reference: int = field("rate", "set-point of the velocity loop")
    current_reference: int = field("cu", "set-point of the current step, joint-signed")
    velocity_integral: int = field("cu", "integral term of the velocity loop, Q12")
    acceleration_feed: int = field("cu", "the acceleration's smoothed share of the current, Q4")
    mode: int = field("", "MODE_* in use")
    limits: int = field("", "LIMIT_* acting in this tick")
    current_limit: int = field("cu", "after derating")
    seen_sequence: int = field("", "of the set-point the cascade works on")
    # protection and thermal
    bus: int = field("vu", "bus voltage")
    under_ticks: int = field("ticks", "for how long it has been too low")
    over_ticks: int = field("ticks", "for how long it has been too high")
    stall_ticks: int = field("ticks", "for how long the joint has stalled")
    sum_ticks: int = field("ticks", "for how long the sum of the phases has been too large")
    winding: int = field("t16", "winding, the hotter of sensor and model")
    mcu: int = field("t16", "microcontroller")
    model_winding: int = field("t16/2^14", "winding above the air in the model")
    model_housing: int = field("t16/2^14", "housing above the air in the model")
    air: int = field("t16", "air temperature with which the model starts")
    i2t: int = field("cu^2/256 x slow ticks", "square of the current less that of i2t_current, summed")
    heat_sum: int = field("cu^2/256", "sum over the motion ticks since the last slow tick")
    heat_ticks: int = field("ticks", "how many ticks that sum has")
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
    range_exceeded: int = field("", "1: position has reached the end of its range")
    # homing
    home_ticks: int = field("ticks", "duration of the search")
    home_still_ticks: int = field("ticks", "for how long the joint has pushed at rest")
    home_result: int = field("", "HOME_*")
    home_rate: int = field("rate", "speed the search asks for")
    raised: int = field("", "FAULT_* raised by homing or commissioning, taken by the next tick")
    raised_value: int = field("", "in the unit of that fault")


TORQUE_OFF = const(0)  # bridge off, the joint coasts
TORQUE_DAMP = const(1)  # only against the motion, no set-point
TORQUE_DRIVE = const(2)  # what the set-points ask for
