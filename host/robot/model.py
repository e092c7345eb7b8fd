"""A robot as its file describes it: frozen tables of SI numbers, one class per table of the TOML file.

The actuators and buses are in actuators.py. Attributes have the file's names; angles are degrees in the
file (``_deg``), and properties give them in radians (``_rad``).
Legs FR, FL, RR, RL = 0..3; joints hip, thigh, calf = 0..2; x forward, y left, z up; docs/robot-files.md.
"""

from functools import cached_property
from math import floor, hypot, log2, radians
from typing import Annotated, Literal

from pydantic import Field

from .actuators import Bldc, CanBus, NoBus, PdJoint, Servo, ServoBus
from .own_gait import GaitName, OwnGait
from .values import LINE, Table, body_axes, number, numbers, one_of, rising, text, whole

LEG_NAMES = ("FR", "FL", "RR", "RL")
JOINT_NAMES = ("hip", "thigh", "calf")
KNEE_SIGNS = {"elbow": -1, "knee": 1}
KNEE_CONFIGURATIONS = ("full-elbow", "full-knee", "elbow-knee", "knee-elbow")
# Two squared lengths must add up to less than 2^30 in the core, so a stretched leg has at most this many units.
LARGEST_REACH_LU = 32700

Pair = tuple[float, float]
Vector = tuple[float, float, float]

PositiveLength = Annotated[float, number(0.01, 1.0, "m")]
Mass = Annotated[float, number(0.001, 100.0, "kg")]
Position = Annotated[Vector, numbers(3, -1.0, 1.0, "m", "x, y, z")]
Line = Annotated[str, text(LINE, "one line of 1 .. 200 printable characters")]
Fraction = Annotated[float, number(0.0, 1.0)]


class HipPositions(Table):
    """Where the hip axes are, (x, y) from the middle of the four, m."""

    FR: Annotated[Pair, numbers(2, -2.0, 2.0, "m", "x, y")]
    FL: Annotated[Pair, numbers(2, -2.0, 2.0, "m", "x, y")]
    RR: Annotated[Pair, numbers(2, -2.0, 2.0, "m", "x, y")]
    RL: Annotated[Pair, numbers(2, -2.0, 2.0, "m", "x, y")]


class Geometry(Table):
    """Lengths, and which way the knees point (paper A, figures 2 and 4)."""

    hip_offset_m: Annotated[float, number(0.0, 0.5, "m")]
    thigh_m: PositiveLength
    calf_m: PositiveLength
    foot_radius_m: Annotated[float, number(0.001, 0.1, "m")]
    foot_friction: Annotated[float, number(0.05, 2.0)]
    knee_configuration: Annotated[str, one_of(*KNEE_CONFIGURATIONS)]
    hips_m: HipPositions

    @property
    def links_m(self) -> Vector:
        """Hip offset, thigh, calf."""
        return self.hip_offset_m, self.thigh_m, self.calf_m

    @property
    def leg_m(self) -> float:
        """Thigh and calf."""
        return self.thigh_m + self.calf_m

    @property
    def reach_m(self) -> float:
        """Hip to foot of a stretched leg."""
        return hypot(self.hip_offset_m, self.leg_m)


class Stance(Table):
    """Where the feet stand at rest and how low the body sits."""

    rest_height_m: PositiveLength
    sit_height_m: PositiveLength
    foot_forward_m: Annotated[float, number(-0.5, 0.5, "m")]
    foot_outward_m: Annotated[float, number(-0.5, 0.5, "m")]


class JointLimits(Table):
    """Joint angles of a left elbow leg; Robot.joint_limits_rad mirrors them for the other legs."""

    hip_deg: Annotated[Pair, rising(-90, 90)]
    thigh_deg: Annotated[Pair, rising(-180, 180)]
    calf_deg: Annotated[Pair, rising(-175, 0)]


class Link(Table):
    """A rigid body: mass, moments about its centre of mass (x, y, z), centre from its upper joint."""

    mass_kg: Mass
    inertia_kg_m2: Annotated[Vector, numbers(3, 1e-9, 100.0, "kg m2", "x, y, z")]
    com_m: Position


class Trunk(Link):
    """The body without legs; positions from the middle of the four hips."""

    size_m: Annotated[Vector, numbers(3, 0.01, 2.0, "m", "length, width, height")]
    payload_m: Position


class Links(Table):
    """The rigid bodies; hip, thigh and calf of a left elbow leg, all legs alike."""

    trunk: Trunk
    hip: Link
    thigh: Link
    calf: Link


class CalfDrive(Table):
    """How the calf's motor reaches the calf: on the thigh, or on the body with a rod along the thigh."""

    motor_on: Annotated[Literal["thigh", "body"], one_of("thigh", "body")]
    ratio: Annotated[float, number(0.1, 10.0)]

    @property
    def coupled(self) -> bool:
        """True if the motor sets the calf's angle against the body: motor = thigh + calf (paper B)."""
        return self.motor_on == "body"


class Control(Table):
    """The planner's rate."""

    rate_hz: Annotated[int, whole(20, 500, "Hz")]


class SpeedLimits(Table):
    """Largest commanded speeds and how fast they change."""

    vx_m_s: Annotated[float, number(0.001, 3.0, "m/s")]
    vy_m_s: Annotated[float, number(0.001, 3.0, "m/s")]
    wz_rad_s: Annotated[float, number(0.01, 10.0, "rad/s")]
    vx_m_s2: Annotated[float, number(0.001, 30.0, "m/s2")]
    vy_m_s2: Annotated[float, number(0.001, 30.0, "m/s2")]
    wz_rad_s2: Annotated[float, number(0.001, 100.0, "rad/s2")]
    stride_m: Annotated[float, number(0.005, 1.0, "m")]


class BodyLimits(Table):
    """Largest commanded body pose, to either side of rest, and how fast it changes."""

    x_m: Annotated[float, number(0.0, 0.5, "m")]
    y_m: Annotated[float, number(0.0, 0.5, "m")]
    z_m: Annotated[float, number(0.0, 0.5, "m")]
    roll_deg: Annotated[float, number(0.0, 60.0, "deg")]
    pitch_deg: Annotated[float, number(0.0, 60.0, "deg")]
    yaw_deg: Annotated[float, number(0.0, 60.0, "deg")]
    shift_m_s: Annotated[float, number(0.001, 2.0, "m/s")]
    turn_deg_s: Annotated[float, number(0.1, 720.0, "deg/s")]

    @property
    def angles_rad(self) -> Vector:
        """Roll, pitch, yaw."""
        return radians(self.roll_deg), radians(self.pitch_deg), radians(self.yaw_deg)

    @property
    def turn_rad_s(self) -> float:
        """How fast the body's angles may change."""
        return radians(self.turn_deg_s)


class Stand(Table):
    """Standing up and sitting down."""

    joint_rad_s: Annotated[float, number(0.01, 10.0, "rad/s")]
    torque_fraction: Annotated[float, number(0.05, 1.0)]


class Balance(Table):
    """The two PIDs of roll and pitch (paper A, section 2.5.2)."""

    kp: Annotated[float, number(0.0, 7.9)]
    ki_1_s: Annotated[float, number(0.0, 100.0, "1/s")]
    kd_s: Annotated[float, number(0.0, 0.4, "s")]
    integral_limit_rad: Annotated[float, number(0.0, 1.5, "rad")]
    output_limit_rad: Annotated[float, number(0.0, 1.5, "rad")]


class Gait(Table):
    """The gait after start-up, the gaits that suit the robot, and what all share; shared/gait/gaits.py has the gaits.

    host/robot/gait_advice.py knows which gaits are advised, including those that are not named here.
    """

    default: GaitName
    advised_m_s: dict[GaitName, Annotated[float, number(0.001, 3.0, "m/s")]] = Field(default_factory=dict)
    not_advised: dict[GaitName, Line] = Field(default_factory=dict)
    own: tuple[OwnGait, ...] = ()
    sag_compensation: Annotated[float, number(0.0, 1.5)]
    lateral_shift: Annotated[float, number(0.0, 1.5)]
    fallen_deg: Annotated[float, number(10.0, 90.0, "deg")]

    @property
    def fallen_rad(self) -> float:
        """Roll or pitch beyond which the robot has fallen."""
        return radians(self.fallen_deg)


class Imu(Table):
    """The inertial sensor's scales, and which of its axes points along x, y, z of the body."""

    gyro_counts_per_deg_s: Annotated[float, one_of(131.0, 65.5, 32.8, 16.4)]
    accel_counts_per_g: Annotated[int, one_of(16384, 8192, 4096, 2048)]
    axes: Annotated[tuple[str, str, str], body_axes()]
    trust_time_s: Annotated[float, number(0.05, 60.0, "s")]
    tolerance_g: Annotated[float, number(0.01, 0.9, "g")]
    align_time_s: Annotated[float, number(0.1, 10.0, "s")]


class Simulation(Table):
    """How realistic the simulators are when this robot walks; the real robot does not use this table.

    ``honest``: the drives as far as the file describes them, and parts that hit each other; else only linear laws.
    ``ground_N_m``: the foot load that presses soft ground in by 1 m, in three dimensions; 0 is hard ground.
    """

    honest: Annotated[bool, one_of(True, False)] = True
    self_collision: Annotated[bool, one_of(True, False)] = True
    ground_N_m: Annotated[float, number(0.0, 1e6, "N/m")] = 0.0


class Robot(Table):
    """One robot file, checked. Only host/robot/file.py makes it."""

    name: Annotated[str, text("[a-z][a-z0-9_-]{0,30}", "lower-case letters, digits, - and _, at most 31")]
    description: Line
    geometry: Geometry
    stance: Stance
    joint_limits: JointLimits
    links: Links
    calf_drive: CalfDrive
    actuator: Annotated[Servo | Bldc | PdJoint, Field(discriminator="kind")]
    bus: Annotated[ServoBus | CanBus | NoBus, Field(discriminator="kind")]
    control: Control
    speed_limits: SpeedLimits
    body_limits: BodyLimits
    stand: Stand
    balance: Balance
    gait: Gait
    crawl: dict[str, Annotated[float, number(-30.0, 30.0)]] = Field(default_factory=dict)  # host/robot/crawl_tuning.py
    trot: dict[str, Annotated[float, number(0.0, 10.0)]] = Field(default_factory=dict)  # host/robot/trot_tuning.py
    imu: Imu
    simulation: Simulation = Simulation()

    @property
    def mass_kg(self) -> float:
        """The whole robot without payload."""
        links = self.links
        return links.trunk.mass_kg + 4 * (links.hip.mass_kg + links.thigh.mass_kg + links.calf.mass_kg)

    @cached_property
    def length_shift(self) -> int:
        """The core's length unit is 2^-length_shift m: the finest in which a leg's squares fit 30 bits."""
        return floor(log2(LARGEST_REACH_LU / self.geometry.reach_m))

    def simulated(self, honest: bool | None) -> "Robot":
        """Return the robot with honest drives, or with simple ones; None: as its file says."""
        if honest is None:
            return self
        return self.model_copy(update={"simulation": self.simulation.model_copy(update={"honest": honest})})

    def hip_m(self, leg: int) -> Pair:
        """Return (x, y) of a leg's hip axis in the body."""
        position: Pair = getattr(self.geometry.hips_m, LEG_NAMES[leg])
        return position

    def side(self, leg: int) -> int:
        """Return +1 for a left leg, -1 for a right one."""
        return -1 if LEG_NAMES[leg][1] == "R" else 1

    def knee_sign(self, leg: int) -> int:
        """Return -1 for a knee behind the hip (elbow), +1 for one in front (knee)."""
        front, _, rear = self.geometry.knee_configuration.partition("-")
        if front == "full":
            return KNEE_SIGNS[rear]
        return KNEE_SIGNS[front if LEG_NAMES[leg][0] == "F" else rear]

    def joint_limits_rad(self, leg: int) -> tuple[Pair, Pair, Pair]:
        """Return (lowest, highest) of hip, thigh and calf: the hip mirrors by side, thigh and calf by knee."""
        limits, turned = self.joint_limits, self.knee_sign(leg) > 0
        return (
            _radians(limits.hip_deg, self.side(leg) < 0),
            _radians(limits.thigh_deg, turned),
            _radians(limits.calf_deg, turned),
        )

    def foot_m(self, leg: int, height_m: float) -> Vector:
        """Return the foot of a standing leg from its hip (x, y, z), the hip ``height_m`` above the foot's centre."""
        outward_m = self.geometry.hip_offset_m + self.stance.foot_outward_m
        return self.stance.foot_forward_m, self.side(leg) * outward_m, -height_m


def _radians(limits_deg: Pair, mirrored: bool) -> Pair:
    low, high = radians(limits_deg[0]), radians(limits_deg[1])
    return (-high, -low) if mirrored else (low, high)
