"""What commissioning remembers from tick to tick, its phases, and how a phase ends."""

from ..record import field, record, vector
from ..runtime import Ints, const, hot
from .faults import FAULT_NONE
from .layout import WAVES

COMMISSION_FULL = const(1)  # everything, from an unknown motor on: the rotor goes round once
COMMISSION_VERIFY = const(2)  # direction and offset are compared with the stored ones; nothing is changed
STEPS = const(10)  # current steps in a tick
COGGING_BINS = const(512)  # of the table over which the cogging is added up


@record
class Commission:
    """A commissioning under way and what it found, or the reason of the last one."""

    kind: int = field("", "COMMISSION_*, 0 while none is running")
    phase: int = field("", "PHASE_*")
    phase_ticks: int = field("ticks", "since this phase began")
    reason: int = field("", "FAULT_COMMISSION_* of the last one, 0 if it succeeded")
    reason_value: int = field("", "in the unit of that fault")
    pose_given: int = field("", "1: the joint stands at pose when commissioning starts")
    pose: int = field("rc", "joint-signed")
    final_kp: int = field("vu / cu", "gain of the current loop once commissioning ends, Q13")
    final_ki: int = field("vu / cu / step", "likewise")
    # at rest
    raw_sum: Ints = vector(3, "count", "phases a, b, c at rest, summed")
    lowest: Ints = vector(4, "", "lowest readings at rest, of phases a, b, c in counts and of the rotor in rc")
    highest: Ints = vector(4, "", "highest, likewise")
    rest_rotor: int = field("rc", "rotor when commissioning started")
    rest_joint: int = field("1/16384 joint turn", "joint encoder when commissioning started")
    # winding
    level: int = field("vu", "voltage that gives the commissioning current")
    window: int = field("ticks", "length of the next sums")
    current_high_q4: int = field("cu", "mean current at that voltage")
    dead_q4: int = field("vu", "voltage lost to dead time, Q4")
    resistance: int = field("vu / cu", "of a phase, Q16")
    inductance_d: int = field("vu step / cu", "along the flux, Q16")
    inductance_q: int = field("vu step / cu", "across it, Q16")
    # turn
    angle: int = field("brad", "angle of the field, not wrapped")
    travel: int = field("brad", "how far the field turns")
    moved: int = field("rc", "rotor's way since the field began to turn")
    rotor_last: int = field("rc", "rotor in the tick before")
    joint_moved: int = field("1/16384 joint turn", "joint's way since then")
    joint_last: int = field("1/16384 joint turn", "joint encoder in the tick before")
    moved_first: int = field("rc", "rotor's way in the field's first electrical turn")
    moved_seen: int = field("rc", "rotor's way when the field last completed an electrical turn")
    moved_forward: int = field("rc", "rotor's way on the first pass forward")
    joint_moved_forward: int = field("1/16384 joint turn", "joint's way on the first pass forward")
    direction: int = field("", "found: +-1")
    pole_pairs: int = field("", "found")
    start_rotor: int = field("rc", "rotor when the field began to turn")
    error_sum: int = field("brad rc", "field less rotor, times the rotor's way, summed")
    error_way: int = field("rc", "sum of these ways")
    harmonic_sum: Ints = vector(4, "brad rc", "the same times cosine and sine of the rotor's angle and of twice that")
    mean_back: int = field("brad", "mean of field less rotor on the way back")
    lag: int = field("brad", "by which friction holds the rotor behind the field")
    play_sum: int = field("rc^2", "of a round: joint encoder less rotor, times the rotor's way, in rc of the rotor")
    offset_found: int = field("brad", "electrical offset found")
    bend: Ints = vector(4, "rc", "found: JointSettings.bend_cos1 and so on, Q4")
    # spin
    centre: int = field("rc", "value of moved about which the rotor swings")
    sign: int = field("", "+-1: electrical direction in which the rotor is to turn")
    half_swings: int = field("", "half swings done")
    way: int = field("rc", "sum of all ways in the direction turned")
    dead_sum_d: int = field("vu ticks", "voltage lost to dead time along the flux, with that sign, Q4")
    dead_sum_q: int = field("vu ticks", "across it, likewise")
    flux: int = field("vu / (8 rate)", "found: JointSettings.bemf, Q16")
    current_change: int = field("cu", "sum of all changes of the current along the motion")
    # proofs of the loops
    proved: int = field("", "error over response to a sine of the current, Q12, both axes; then bandwidth, per cent")
    repeated: int = field("", "how often the present proof was measured again")
    velocity_w: int = field("rad / tick", "found: the velocity loop's bandwidth, the wanted one or less, Q16")
    run_ticks: int = field("ticks", "since a run's windows began; -1 before that")
    goal: int = field("rc/256", "goal of the position loop, from centre, electrical-signed")
    # mechanics
    swing_position: int = field("rc", "from the middle of the swing, electrical-signed")
    swing_level: int = field("", "0: by the current; 1, 2: by the velocity loop; 3: likewise at half of the speed")
    swing_rate: int = field("rate", "speed of the swing")
    swing_acceleration: int = field("rate/tick", "acceleration with which the velocity loop swings the rotor")
    swing_reference: int = field("rate", "rate wanted at present, electrical-signed")
    periods: int = field("", "whole swings done; -1 before the first")
    period_ticks: int = field("ticks", "time that they took")
    impulse: int = field("cu ticks", "sum of the current, times 10")
    work_in: int = field("cu rc", "work of the current on the way to the middle, times 10 / 1024")
    work_out: int = field("cu rc", "on the way from it, likewise")
    way_in: int = field("rc", "signed sum of the ways to the middle")
    square_middle: int = field("rc^3/tick^2", "squared speed times way near the middle, summed, 1/4096 of it")
    way_middle: int = field("rc", "sum of these ways")
    square_way: int = field("rc^2/tick", "sum of speed times way, 1/16 of it")
    friction_q4: Ints = vector(4, "cu", "at each level, Q4")
    speed_q4: Ints = vector(4, "rc/tick", "mean over the way, of each level, Q4")
    outer_before: Ints = vector(5, "", "gains of the outer loops before commissioning (outer.py); the first 0: none")
    inertia: int = field("cu / (rate / tick)", "found, with the load on the rotor, Q12")
    coulomb: int = field("cu", "found: friction at rest, Q4")
    viscous: int = field("cu / rate", "found: how friction grows with the speed, Q16")
    backlash: int = field("rc", "found: rotor encoder against joint encoder, Q4; -1 without a joint encoder")
    # cogging
    field_q6: int = field("brad", "angle of the field that holds the rotor, 0 .. 65535, Q6")
    flux_taken: int = field("", "share of the flux that the current of that field takes, in 1/256")
    creep_rounds: int = field("", "short rounds done")
    creep_part: int = field("", "CREEP_* of the round (creeping.py)")
    wave: int = field("", "wave being checked")
    rejected_waves: int = field("", "waves that left too much of the ripple, bits")
    ripple: Ints = vector(WAVES, "rate", "ripple of the speed without the waves, at the order of each, times 1.6")
    creep_far: int = field("rc", "distance from the middle within which a round counts")
    creep_settled: int = field("", "1: two short rounds have found the same first wave")
    order_before: int = field("", "the strongest wave in the round before: how often a turn")
    current_before: int = field("cu", "its amplitude, Q4")
    phase_before: int = field("brad", "its phase")
    moved_last: int = field("rc", "rotor's way in the tick before, electrical-signed")
    moved_before: int = field("rc", "in the tick before that")
    current_last: int = field("cu", "current in the tick before, times 10")
    table_repeats: int = field("", "how often a turn the table repeats: once per pole, or 1")
    bin_last: int = field("", "bin of the table in the tick before")
    order: int = field("", "how often the wave that is looked for comes in the table")
    order_last: int = field("", "last order to look for")
    bin_next: int = field("", "next bin of the table")
    cosine_sum: int = field("cu rc", "table times the cosine of that wave, times 10 / 256")
    sine_sum: int = field("cu rc", "table times its sine, likewise")
    wave_order: Ints = vector(WAVES, "", "found: how often a turn, 0 none")
    wave_current: Ints = vector(WAVES, "cu", "found: amplitude, Q4")
    wave_phase: Ints = vector(WAVES, "brad", "found: phase at the rotor's reading 0")
    cogging_bins: Ints = vector(COGGING_BINS, "cu rc", "current times the rotor's way in each bin, times 10")


PHASE_IDLE = const(0)
PHASE_REST = const(1)
PHASE_RAMP = const(2)
PHASE_SETTLE = const(3)
PHASE_HIGH = const(4)
PHASE_LOW = const(5)
PHASE_ALTERNATE_D = const(6)
PHASE_ALTERNATE_Q = const(7)
PHASE_PROVE_CURRENT = const(8)
PHASE_FORWARD = const(9)
PHASE_BACK = const(10)
PHASE_AGAIN = const(11)
PHASE_SPIN = const(12)
PHASE_SWING = const(13)
PHASE_CREEP = const(14)
PHASE_ROUND = const(15)
PHASE_WAVES = const(16)
PHASE_PROVE_VELOCITY = const(17)
PHASE_PROVE_POSITION = const(18)


@hot
def fail(commission: Commission, reason: int, value: int) -> int:
    """End commissioning with a reason, unless there is one already; return ``reason``."""
    if commission.reason == FAULT_NONE:
        commission.reason = reason
        commission.reason_value = value
    commission.phase = PHASE_IDLE
    return reason


@hot
def begin_phase(commission: Commission, phase: int) -> int:
    """Begin ``phase``; return it."""
    commission.phase = phase
    commission.phase_ticks = 0
    return phase
