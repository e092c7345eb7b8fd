"""A robot's figures for the trot, from its file alone: times from sqrt(h/g) and drives' lags, lengths from the leg.

The remaining constants are below, the same for every robot. They were found on Caramelo and Parallel in MuJoCo, on
level ground and at steps of up to a fifth of the leg. A robot file's table ``trot`` can override those in NUMBERS.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import cos, hypot, inf, pi, sin, sqrt, tanh

from shared.body.params import LF_BITS, Params
from sim2d.model import GRAVITY_M_S2

from .drives import friction_bands, joint_drives
from .kinematics_si import Vector
from .mass import com_at_rest_m
from .model import JOINT_NAMES, Robot
from .swings import asked_speeds, leg_of_each_shape, most, poses_rad, within_limits

GAIT = "trot"  # whose figures these are
LOW_LIFT, HIGH_LIFT = 0.08, 0.30  # of the leg: top of a swing on even ground, and after a foot met something
HIGHEST_LIFT = 0.45  # of the leg: for a foot that was held up in its last swing
AHEAD_FROM, AHEAD_TO = 0.2, 0.9  # of such a swing: the foot goes ahead in between, until then it rises
DRAW_BACK = 0.04  # of the leg: how far such a foot is drawn back while it rises
LAGS_IN_SWING = 2.0  # times the drives' lag, added to sqrt(h/g): the duration of a swing
STANCE_SHARE = 0.55  # of a cycle; above 1/2, so that the diagonals overlap
AHEAD_SHARE = 0.8  # of a swing: then a foot's motion along the ground ends, so that it is over at touchdown despite lag
CAPTURE_SHARE = 0.5  # of the dead-beat gain of the linear inverted pendulum
CAPTURE_MOST = 0.3  # of the height: the furthest such step; no further than legs give, whose push throws the body aside
PUSHED_FROUDE = 0.12  # of sqrt(g h), faster than told: pushed; 0.08 on level ground, 0.19 under the heaviest load
HURRY = 1.75  # times the usual pace while pushed: of pushes of Caramelo more fall with 1.5, and no less with 2
LEVEL_SHARE = 1.0  # of sqrt(g/h): how fast the legs correct a tilt
CAREFUL_FROUDE = 0.07  # of sqrt(g h): up to this speed a robot walks with care on uneven ground; what follows was found
# in the plane on stones of 12 mm: with it Caramelo pitched by at most 5 deg in 38 of 40 walks, without it in 3 of 20
CAREFUL_LEVEL, CAREFUL_LEAD_S = 2.0, 0.02  # times the usual correction of a tilt, and how far ahead that is foreseen
CAREFUL_LIFT = 0.12  # of the leg: top of a swing; lower ones strike stones
CAREFUL_PACE = 0.4  # of the usual pace while all feet stand, so that the body is level when a diagonal lifts off
LEAD_MOST_S = 0.03  # a tilt is foreseen no further ahead: with 42 ms Mini Cheetah took its own wobble for a fall
HEADING_HZ = 2.0  # rad/s of turn per rad of heading error
SLOPE_CYCLES = 1.0  # over which the ground's slope is averaged
DRIFT_SHARE = 0.5  # of the speed's error, corrected per cycle
DRIFT_LEAST_M_S = 0.02  # largest such correction at rest; plus 0.3 of the speed (shared/trot/steer.py)
UNHINDERED_LAG_SHARE = 0.3  # of the drives' lag remains for an unhindered foot when half of it is compensated
FRICTION_SHARE = 1 / 8  # of a drive's no-load speed: from here on its friction is fed forward in full
LANDING_SHARE = 1 / 8  # of a cycle, and the bus delay: while a foot lands, it may stand on ground higher than planned
LOAD_SHARE = 0.15  # of a stance, in which half of the weight shifts onto the foot
HELD_PUSH = 0.285  # of the weight: a foot in the air that pushes so hard is held up; stiff legs push before they lag
TURN_LATE_S = 0.05  # that a foot in the air may be late in a turn, where the two feet of a diagonal go different ways
LATE_PER_S = 25.0  # growth of a foot's allowed lag per second of bus delay, as a share, while the foot moves ahead
LATE_UNLIKE = 4.0  # the same share where front and hind knees bend unlike: knee legs need faster joints, and lag more
HIGH_LENGTHS = 1.5  # of the body: the way for which swings stay high after a foot met something
HIGH_SPEED = 0.35  # of the leg per cycle: top speed meanwhile
LATE_FROUDE = 0.12  # of sqrt(g h): the same for a robot whose drives are too slow for such swings (slow servos)
HIGH_SLOWEST_M_S = 0.05  # slower counts as this for that way
SWING_ASKS = 1.5  # times a drive's no-load speed is the most that a swing's goals may demand: lag rounds them off
HIGHEST_ASKS = 2.5  # the same of the highest swings; SpotMicro, which would be asked for 2.7, was late in them
HIND_ASKS = 1.0  # the same of an elbow-knee robot: with more its hind feet, which need faster joints, lag behind
STEP_LEG = 0.16  # of the leg: the highest step that every robot should walk up
SWING_POINTS = 25  # of a swing are checked for that
FROUDE_SPEED = 0.4  # of sqrt(g h): no robot was tried at a higher speed
SIDE_SHARE, TURN_SHARE = 0.4, 0.7  # of the forward speed: sideways, and of the feet when turning


@dataclass(frozen=True)
class Number:
    """A number that a robot file can override: its usual value, the least and the most, its unit and meaning."""

    usual: float
    least: float
    most: float
    meaning: str


NUMBERS = {
    "low_lift": Number(LOW_LIFT, 0.03, 0.25, "[of the leg] top of a swing on even ground"),
    "high_lift": Number(HIGH_LIFT, 0.15, 0.40, "[of the leg] the same after a foot met something"),
    "lags_in_swing": Number(LAGS_IN_SWING, 0.0, 6.0, "[-] drives' lags, added to sqrt(h/g): duration of a swing"),
    "stance_share": Number(STANCE_SHARE, 0.51, 0.70, "[-] of a cycle, in which a foot is in stance"),
    "capture_share": Number(CAPTURE_SHARE, 0.0, 1.0, "[-] of the gain with which one step corrects a wrong speed"),
    "level_share": Number(LEVEL_SHARE, 0.3, 2.0, "[-] of sqrt(g/h): how fast the legs correct a tilt"),
    "drift_share": Number(DRIFT_SHARE, 0.0, 1.0, "[-] of the speed's error, corrected per cycle"),
}


def trot_complaints(given: Mapping[str, float]) -> Iterator[tuple[str, object, str]]:
    """Yield (key, value, what is allowed) of each number in a table ``trot`` that can't be used."""
    for key, value in given.items():
        if key not in NUMBERS:
            yield f"trot.{key}", value, f"the keys are {', '.join(NUMBERS)}"
            continue
        number = NUMBERS[key]
        if not number.least <= value <= number.most:
            yield f"trot.{key}", value, f"{number.least:g} .. {number.most:g}, usually {number.usual:g}"


@dataclass(frozen=True)
class TrotFigures:
    """What the trot uses of a robot, SI."""

    leg_m: float
    height_m: float
    length_m: float
    rests_m: tuple[tuple[float, float], ...]
    lag_s: float
    gives_m: float  # a foot, along the ground, under the robot's weight
    own: Mapping[str, float]  # NUMBERS

    @property
    def tipping_s(self) -> float:
        """Time constant of the robot's tipping over a support line."""
        return sqrt(self.height_m / GRAVITY_M_S2)

    @property
    def swing_s(self) -> float:
        """How long a foot is in the air."""
        return self.tipping_s + self.own["lags_in_swing"] * self.lag_s

    @property
    def cycle_s(self) -> float:
        """From a touchdown to the next of the same foot."""
        return self.swing_s / (1 - self.own["stance_share"])

    @property
    def stance_s(self) -> float:
        """How long a foot stands."""
        return self.cycle_s * self.own["stance_share"]

    @property
    def neutral_s(self) -> float:
        """Foothold ahead of rest per speed, with which the pendulum keeps its speed."""
        return self.tipping_s * tanh(self.cycle_s / 4 / self.tipping_s)

    @property
    def capture_s(self) -> float:
        """Foothold further ahead per excess speed."""
        return self.own["capture_share"] * self.tipping_s / tanh(self.cycle_s / 2 / self.tipping_s)

    @property
    def capture_most_m(self) -> float:
        """The furthest such step."""
        return min(CAPTURE_MOST * self.height_m, self.gives_m)

    @property
    def climbing_m_s(self) -> float:
        """Top speed while swings are high."""
        return HIGH_SPEED * self.leg_m / self.cycle_s

    def swing(self, speed_m_s: float, lift_m: float) -> list[tuple[float, float]]:
        """Return the goals of a foot in the air, x ahead of and z above its rest, at SWING_POINTS even times.

        As shared/trot/feet.py plans them for a body at constant speed: a cycloid along the ground, a cosine upwards.
        """
        start_m, way = speed_m_s * (self.neutral_s - self.stance_s), []
        for point in range(SWING_POINTS):
            share = point / (SWING_POINTS - 1)
            turn = 2 * pi * min(1.0, share / AHEAD_SHARE)
            gone_m = speed_m_s * (self.cycle_s * (turn - sin(turn)) / (2 * pi) - self.swing_s * share)
            way.append((start_m + gone_m, lift_m * (1 - cos(2 * pi * share)) / 2))
        return way


def trot_figures(robot: Robot) -> TrotFigures:
    """Return the figures of a robot."""
    geometry, height_m, com_m, rests = robot.geometry, robot.stance.rest_height_m, com_at_rest_m(robot), []
    (_, thigh, calf), usual = joint_drives(robot), {key: number.usual for key, number in NUMBERS.items()}
    for leg in range(4):
        hip, foot = robot.hip_m(leg), robot.foot_m(leg, height_m)
        rests.append((hip[0] + foot[0] + com_m[0], hip[1] + foot[1] + com_m[1]))
    return TrotFigures(
        geometry.thigh_m + geometry.calf_m, height_m, robot.hip_m(0)[0] - robot.hip_m(2)[0], tuple(rests),
        calf.damping_Nms_rad / calf.stiffness_Nm_rad,
        robot.mass_kg * GRAVITY_M_S2 * height_m**2 / thigh.stiffness_Nm_rad, usual | robot.trot,
    )


def able(robot: Robot) -> tuple[float, str]:
    """Return the highest forward speed of the legs, m/s, and what limits it.

    A joint that reaches its limit in a swing stays there, which does not slow the robot.
    """
    figures = trot_figures(robot)
    froude_m_s = FROUDE_SPEED * sqrt(GRAVITY_M_S2 * figures.height_m)
    lift_m = figures.own["low_lift"] * figures.leg_m
    asks = HIND_ASKS if robot.geometry.knee_configuration == "elbow-knee" else SWING_ASKS
    speed_m_s = most(froude_m_s, lambda v: max(_asked(robot, figures, v, lift_m)) <= asks)
    if speed_m_s == froude_m_s:
        return froude_m_s, f"{FROUDE_SPEED:g} sqrt(g h), the highest that was tried"
    return speed_m_s, _too_slow(_asked(robot, figures, speed_m_s * 1.01 + 0.001, lift_m))


def highest_lift_m(robot: Robot) -> tuple[float, str]:
    """Return how high a swing can go while the trot climbs, and what limits it."""
    figures = trot_figures(robot)
    speed_m_s, wanted_m = min(figures.climbing_m_s, able(robot)[0]), figures.own["high_lift"] * figures.leg_m

    def can(lift_m: float) -> bool:
        for leg in leg_of_each_shape(robot):
            poses = poses_rad(robot, leg, figures.swing(0.0, lift_m))
            if poses is None or not within_limits(robot, leg, poses):
                return False
        return max(_asked(robot, figures, speed_m_s, lift_m)) <= SWING_ASKS

    lift_m = most(wanted_m, can)
    if lift_m == wanted_m:
        return lift_m, f"{figures.own['high_lift']:g} of the leg, the trot's own limit"
    asked = _asked(robot, figures, speed_m_s, lift_m * 1.01 + 0.0001)
    return lift_m, _too_slow(asked) if max(asked) > SWING_ASKS else "the joints' limits"


def top_lift_m(robot: Robot) -> float:
    """Return the apex of a swing after one that was held up: as high as drives that are late in it still go in time."""
    figures = trot_figures(robot)
    lift_m = most(HIGHEST_LIFT * figures.leg_m, lambda lift: max(_asked(robot, figures, 0.0, lift)) <= HIGHEST_ASKS)
    return max(lift_m, figures.own["high_lift"] * figures.leg_m)


def high_speed_m_s(robot: Robot) -> float:
    """Return the top speed while swings are high: less if the drives are too slow for them even on the spot."""
    figures = trot_figures(robot)
    if can_lift(robot, figures, 1.0):
        return figures.climbing_m_s
    return min(figures.climbing_m_s, LATE_FROUDE * sqrt(GRAVITY_M_S2 * figures.height_m))


def can_lift(robot: Robot, figures: TrotFigures, pace: float) -> bool:
    """Return whether the drives follow a high swing on the spot at ``pace`` times its usual pace."""
    return pace * max(_asked(robot, figures, 0.0, figures.own["high_lift"] * figures.leg_m)) <= SWING_ASKS


def _asked(robot: Robot, figures: TrotFigures, speed_m_s: float, lift_m: float) -> Vector:
    """Return the drive speeds that a swing demands of the leg that needs most; infinite out of reach."""
    asked = []
    for leg in leg_of_each_shape(robot):
        poses = poses_rad(robot, leg, figures.swing(speed_m_s, lift_m))
        if poses is None:
            return inf, inf, inf
        asked.append(asked_speeds(robot, poses, figures.swing_s))
    return max(asked, key=max)


def _too_slow(asked: Vector) -> str:
    """Return in words which joint is too slow, or that the legs are too short."""
    return "the legs' reach" if max(asked) == inf else f"the {JOINT_NAMES[asked.index(max(asked))]}'s speed"


def fastest(robot: Robot) -> tuple[float, float, float]:
    """Return the top commands, m/s forward and sideways and rad/s: what the legs can do and the robot file allows."""
    ahead_m_s, limits = able(robot)[0], robot.speed_limits
    turn_rad_s = TURN_SHARE * ahead_m_s / hypot(*trot_figures(robot).rests_m[0])
    return min(ahead_m_s, limits.vx_m_s), min(SIDE_SHARE * ahead_m_s, limits.vy_m_s), min(turn_rad_s, limits.wz_rad_s)


def limit(robot: Robot) -> str:
    """Return what limits the trot's forward speed: a key of the robot file, or the legs."""
    most_m_s, why = able(robot)
    return "speed_limits.vx_m_s" if robot.speed_limits.vx_m_s < most_m_s else why


def rolling(robot: Robot) -> float:
    """Return the speed of a round foot's centre per speed of the body: it rolls on its radius."""
    return 1 / (1 + robot.geometry.foot_radius_m / robot.stance.rest_height_m)


def fill_careful(params: Params, f: TrotFigures, level: float) -> None:
    """Write how the robot walks with care; ``level``: the usual gain as the core has it. Part of fill_trot."""
    rate, setup, unit = params.rate_hz, params.trot, 1 << params.length_shift
    setup.careful_speed = round(CAREFUL_FROUDE * sqrt(GRAVITY_M_S2 * f.height_m) / rate * (unit << LF_BITS))
    setup.careful_kp_q12 = min((1 << 17) - 1, round(CAREFUL_LEVEL * level))
    setup.careful_lead_q12 = round(CAREFUL_LEAD_S * rate * 65536 / 2 / pi / 2**18 * 4096)
    setup.careful_lift = min(setup.high_lift, max(setup.low_lift, round(CAREFUL_LIFT * f.leg_m * unit)))
    setup.careful_step_q20 = round(2**20 * CAREFUL_PACE / f.cycle_s / rate)


def fill_trot(params: Params, robot: Robot) -> None:
    """Write the figures as the core's integers at the rate of ``params`` (shared/body/trot_setup.py)."""
    f, rate, setup = trot_figures(robot), params.rate_hz, params.trot
    unit = 1 << params.length_shift
    fine = unit << LF_BITS
    setup.phase_step_q20 = round(2**20 / f.cycle_s / rate)
    setup.hurried_step_q20 = round(2**20 * HURRY / f.cycle_s / rate)
    setup.hurries_high = int(can_lift(robot, f, HURRY))
    setup.pushed_speed = round(PUSHED_FROUDE * sqrt(GRAVITY_M_S2 * f.height_m) / rate * fine)
    setup.stance_q20 = round(2**20 * f.own["stance_share"])
    landing_q20 = round(2**20 * LANDING_SHARE) + params.delay_ticks * setup.phase_step_q20
    # over before the last tick of a stance: what a foot met must be forgotten when it swings again
    setup.landing_q20 = min(landing_q20, setup.stance_q20 - setup.hurried_step_q20 - 1)
    setup.swing_rate_q13 = round(2**13 / (1 - f.own["stance_share"]))
    setup.ahead_rate_q13 = round(2**13 / AHEAD_SHARE)
    setup.rise_first_q15, setup.rise_first_rate_q13 = round(32768 * AHEAD_FROM), round(2**13 / (AHEAD_TO - AHEAD_FROM))
    setup.draw_back = round(DRAW_BACK * f.leg_m * unit)
    setup.swing_q8 = round(f.swing_s * rate * 256)
    setup.height = round(f.height_m * unit)
    setup.low_lift, setup.high_lift = (round(f.own[key] * f.leg_m * unit) for key in ("low_lift", "high_lift"))
    setup.highest_lift = round(top_lift_m(robot) * unit)
    setup.turn_side = round(2 * abs(f.rests_m[0][1]) * TURN_LATE_S * rate * unit / 256)
    setup.push_lag = round(HELD_PUSH * f.gives_m * unit)
    unlike = len(leg_of_each_shape(robot)) > 1
    setup.late_lag_q8 = round(256 * max(LATE_PER_S * robot.bus.delay_s, LATE_UNLIKE if unlike else 0.0))
    setup.high_distance = round(HIGH_LENGTHS * f.length_m * fine)
    setup.high_speed = round(high_speed_m_s(robot) / rate * fine)
    setup.high_slowest = round(HIGH_SLOWEST_M_S / rate * fine)
    setup.neutral_q8, setup.capture_q8 = round(f.neutral_s * rate * 256), round(f.capture_s * rate * 256)
    setup.capture_max = round(f.capture_most_m * unit)
    level = f.own["level_share"] / f.tipping_s / rate * 2 * pi / 65536 * 2**18 * 4096
    setup.level_kp_q12 = round(level)
    fill_careful(params, f, level)
    setup.height_kp_q16 = round(65536 / 2 / f.cycle_s / rate)
    setup.speed_filter_q10 = round(1024 / (1 + f.stance_s / 4 * rate))
    setup.speed_ki_q15 = round(f.own["drift_share"] / f.cycle_s / rate * 32768)
    setup.speed_integral_least = round(DRIFT_LEAST_M_S / rate * fine)
    setup.heading_kp_q16 = round(65536 * HEADING_HZ / rate)
    setup.slope_gain_q15 = round(32768 / (1 + SLOPE_CYCLES * f.cycle_s * rate))
    setup.rolling_q15 = round(32768 * rolling(robot))
    setup.tilt_lead_q8 = round(256 * min(robot.bus.delay_s * rate + 0.5, LEAD_MOST_S * rate))
    setup.lag_q8 = round(f.lag_s * rate * 256)
    dry_rad, of_sag = friction_bands(robot)
    for joint, band_rad in enumerate(dry_rad):
        setup.friction[joint] = min(4095, round(band_rad * 65536 / 2 / pi))
    setup.load_friction_q12 = round(of_sag * 4096)
    setup.friction_rate_q16 = min(16383, round(65536 / (FRICTION_SHARE * params.joint_speed_max.hip)))
    setup.response_q12 = round(4096 / (1 + UNHINDERED_LAG_SHARE * f.lag_s * rate))
    setup.load_step_q12 = max(1, round(2048 / max(1.0, LOAD_SHARE * f.stance_s * rate)))
    for axis, value in enumerate(fastest(robot)):
        setup.speed_max[axis] = min((1 << 18) - 1, round(value / rate * (fine if axis < 2 else 1 << 18)))
