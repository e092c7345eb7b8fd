"""All that the trot remembers, allocated beforehand."""

from ..body.axes import POSE_AXES, Pose, Spot, Tilt
from ..body.feet import Feet
from ..body.legs import LegsWork
from ..body.params import JOINTS, LEGS, LF_BITS, Params
from ..record import field, part, record
from ..runtime import const, hot, zeros
from ..sense.legs import MeasuredFeet
from ..sense.odometry import Odometry

CYCLE_Q20 = const(0x100000)
HISTORY_TICKS = const(16)  # how much of the past is kept; params.delay_ticks is at most 15


@record
class TrotState:
    """What the trot measures and wants, apart from its feet."""

    phase_q20: int = field("Q20 of a cycle", "phase of the diagonal FR RL; the other diagonal is half a cycle on")
    known: int = field("ticks", "for how long joints, tilt and rates have been measured without a gap, up to 100")
    measured_speed: Spot = part(Spot, "measured speed of the body over its stance feet, lf / tick")
    speed_integral_q8: Spot = part(Spot, "what is added to the commanded speed to reach it, lf / tick Q8")
    heading_error_18: int = field("2^-18 rad", "how far the body turned less than commanded")
    foot_speed: Spot = part(Spot, "commanded speed, as seen at the centres of the round feet, lf / tick")
    stance_speed: Spot = part(Spot, "speed at which the stance feet go back, lf / tick")
    turn_18: int = field("2^-18 rad / tick", "wanted turn of the body about z")
    roll_18: int = field("2^-18 rad / tick", "wanted turn about x, which levels the body")
    pitch_18: int = field("2^-18 rad / tick", "wanted turn about y")
    rise_speed: int = field("lf / tick", "wanted speed of the body upwards")
    pushed: int = field("", "1: since this tick too fast, as walking never is; 2: for longer, or at an edge")
    capture: Spot = part(Spot, "capture step: foothold further on for a speed that is too high, lu")
    roll_q14: int = field("rad Q14", "roll as foreseen for when this tick's goals act")
    pitch_q14: int = field("rad Q14", "pitch as foreseen for then")
    tilt_q14: Tilt = part(Tilt, "as measured, rad Q14")
    slope_q20: Spot = part(Spot, "slope of the ground along x and y, averaged, Q20")
    uneven_q4: int = field("lu Q4", "how far the feet stood off the ground's plane, averaged over four times as long")
    careful: int = field("", "1: slow on uneven ground, it walks with care; below 0: ticks until it may")
    swing_q15: int = field("Q15", "elapsed share of the swing of the diagonal in the air")
    lift: int = field("lu", "apex of the next swings")
    high_left: int = field("lf", "way left to go with high swings")
    swinging: int = field("", "legs in swing, bits")
    standing: int = field("", "how many legs stand")
    still_q20: int = field("Q20 of a cycle", "phase passed since the command is to stand, up to 2^21")
    ring_at: int = field("", "this tick's place in the rings, 0 .. 15")
    held_up_count: int = field("", "swings held up since the start, and slow bodies taken for it")
    slow_swings: int = field("", "low swings in a row that began at less than half of the commanded speed")
    early_contacts: int = field("", "feet that met ground higher than planned since the start")
    stuck_ticks: int = field("ticks", "for how long the robot, commanded to walk, has made no progress; else 0")


@record
class TrotCommand:
    """How the trot is to walk, besides speed and pose."""

    moving: int = field("", "0: stand")
    balance: int = field("", "1: keep the body level by the measured attitude")
    height: int = field("lu", "apex of a swing on even ground; 0 or less: the robot's own")


class Trot:
    """The trot of one robot. Feet are in the body, from the middle of the hips; sense_legs measures them."""

    def __init__(self, feet: MeasuredFeet, odometry: Odometry) -> None:
        self.state = TrotState()
        self.command = TrotCommand()
        self.work = LegsWork()
        self.feet = Feet()  # lf, planned
        self.lift_offs = Feet()  # lu, level: where each swing began
        self.measured = feet.now  # lu
        self.before = feet.before  # lu, the same a tick ago
        self.heights = zeros(LEGS)  # lu, of the measured feet that stand, in level axes
        self.odometry = odometry  # the body's speed, as of the tick before: late, but undisturbed by touchdowns
        self.expected_x_q4 = zeros(LEGS)  # lu Q4: where each foot would be if nothing hindered it
        self.expected_z_q4 = zeros(LEGS)
        self.residual_x = zeros(LEGS)  # lu: measured less unhindered
        self.residual_z = zeros(LEGS)
        self.residual_rate = zeros(LEGS)  # lu / tick: how fast residual_x changes
        self.swing_top = zeros(LEGS)  # lu: where the foot was highest since the middle of its swing, in the body
        self.stance = zeros(LEGS)  # 1: the foot stands, by plan or because it met something
        self.early_contact = zeros(LEGS)  # react.EARLY...: it met ground too high in this swing, or on landing from it
        self.apex = zeros(LEGS)  # lu, of the present swings
        self.held_up = zeros(LEGS)  # 1: the foot was held up in its last swing
        self.peak_lag = zeros(LEGS)  # lu: how far the foot was behind its mate at most in its swing
        self.usual_lag = zeros(LEGS)  # lu, the mean of that over swings that were not held up, at most 0.04 of the leg
        self.rises_first = zeros(LEGS)  # 1: held up in its last swing, the foot gets free of that first in this one
        self.shortened = zeros(LEGS)  # lu: by how much less far than planned a swing foot is sent
        self.stuck_score = zeros(LEGS)  # twice the held-up swings, less the others
        self.held_up_in_row = zeros(LEGS >> 1)  # held-up swings in a row: of the front feet, of the hind feet
        self.load_q12 = zeros(LEGS)  # own weight Q12: what each foot is expected to carry
        self.hip_feet = Feet()  # lu from the hips
        self.flags = zeros(LEGS)  # leg.LIMIT_...: which joints of each leg were limited
        self.joints = zeros(JOINTS)  # brad: they reach ``hip_feet``
        self.joints_before = zeros(JOINTS)  # brad: the same a tick ago
        self.last_pose = Pose()  # the pose of the tick before
        self.past_x = zeros(HISTORY_TICKS * LEGS)  # lu: rings of the planned feet
        self.past_z = zeros(HISTORY_TICKS * LEGS)
        self.past_stance = zeros(HISTORY_TICKS)  # bits: ring of the stance legs


@hot
def trot_reset(params: Params, trot: Trot) -> None:
    """Stand at rest, with nothing measured."""
    state = trot.state
    setup = params.trot
    state.phase_q20 = (setup.stance_q20 >> 1) - (CYCLE_Q20 >> 2)
    state.known = 0
    state.pushed = 0
    state.heading_error_18 = 0
    state.lift = setup.low_lift
    state.high_left = 0
    state.uneven_q4 = 0
    state.careful = -2 * params.rate_hz
    state.swinging = 0
    state.standing = LEGS
    state.still_q20 = 0
    state.held_up_count = 0
    state.slow_swings = 0
    state.early_contacts = 0
    state.stuck_ticks = 0
    for axis in range(2):
        state.slope_q20[axis] = 0
        state.measured_speed[axis] = 0
        state.speed_integral_q8[axis] = 0
    for axis in range(POSE_AXES):
        trot.last_pose[axis] = 0
    for leg in range(LEGS):
        limb = params.legs[leg]
        trot.stance[leg] = 1
        trot.early_contact[leg] = 0
        trot.load_q12[leg] = 0
        trot.held_up[leg] = 0
        trot.rises_first[leg] = 0
        trot.shortened[leg] = 0
        trot.peak_lag[leg] = 0
        trot.usual_lag[leg] = 0
        trot.stuck_score[leg] = 0
        trot.held_up_in_row[leg >> 1] = 0
        foot = trot.feet.legs[leg]
        foot.x = limb.rest.x << LF_BITS
        foot.y = limb.rest.y << LF_BITS
        foot.z = limb.rest.z << LF_BITS
