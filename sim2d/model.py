"""A robot's data for the sagittal plane, as frozen SI numbers: no files, no integers.

Frame: x forward, z up. Every rotation is about +y as in REP-103, so a positive angle turns x towards -z:
thigh > 0 puts the knee behind the hip, calf < 0 is a full elbow, pitch > 0 is nose down.
Legs FR, FL, RR, RL = 0..3; joints hip, thigh, calf; a joint's index is leg * 3 + joint.
"""

import itertools
from dataclasses import dataclass, field, replace

GRAVITY_M_S2 = 9.81
LEGS = ("FR", "FL", "RR", "RL")
JOINTS = 12
PLANAR_JOINTS = 8
HIP, THIGH, CALF = 0, 1, 2
_MAX_BRAKING = 0.5  # of its speed is the most that a joint may lose to damping in one sub-step
# The joints that turn in the plane, in the order of every planar array: thigh and calf of each leg.
PLANAR_INDEX = tuple(leg * 3 + joint for leg in range(4) for joint in (THIGH, CALF))


@dataclass(frozen=True)
class Link:
    """One rigid body: its mass, its moment of inertia about its own centre, and where that centre is.

    ``com_x_m`` and ``com_z_m`` are measured from the link's upper joint (the torso's: from the middle of the
    hips) with the leg straight down.
    """

    mass_kg: float
    inertia_kgm2: float
    com_x_m: float
    com_z_m: float

    def __post_init__(self) -> None:
        if not (self.mass_kg > 0 and self.inertia_kgm2 > 0):
            raise ValueError(
                f"link: mass {self.mass_kg} kg and inertia {self.inertia_kgm2} kg m2 must both be above 0"
            )


@dataclass(frozen=True)
class ServoModel:
    """A position drive seen from the joint: torque = clip(stiffness x error, +-stall) - damping x speed.

    That is a servo, whose damping is its motor's own. With a ``speed_loop`` the controller damps, within its
    torque: torque = clip(stiffness x error - damping x speed, +-stall).

    All torques hold at ``nominal_voltage_V``. ``voltage_points`` are the datasheet's (volts, stall torque
    relative to nominal, no-load speed relative to nominal), rising; with none, both go with the voltage.
    ``armature_kgm2`` is the motor's inertia seen through its gear.
    """

    stall_torque_Nm: float
    stiffness_Nm_rad: float
    damping_Nms_rad: float
    armature_kgm2: float
    coulomb_Nm: float
    nominal_voltage_V: float
    voltage_points: tuple[tuple[float, float, float], ...] = ()
    speed_loop: bool = False

    def __post_init__(self) -> None:
        for name in ("stall_torque_Nm", "stiffness_Nm_rad", "damping_Nms_rad", "nominal_voltage_V"):
            if not getattr(self, name) > 0:
                raise ValueError(f"servo: {name} = {getattr(self, name)} must be above 0")
        if self.armature_kgm2 < 0 or self.coulomb_Nm < 0:
            raise ValueError("servo: armature_kgm2 and coulomb_Nm must not be negative")

    def at_voltage(self, voltage_V: float) -> "ServoModel":
        """Return the same servo at another supply voltage: interpolated, never extrapolated.

        Duty per radian is the servo's own setting and stays, so stiffness goes with the stall torque;
        damping = stall torque / no-load speed.
        """
        torque_ratio, speed_ratio = self._ratios(voltage_V)
        return replace(
            self,
            stall_torque_Nm=self.stall_torque_Nm * torque_ratio,
            stiffness_Nm_rad=self.stiffness_Nm_rad * torque_ratio,
            damping_Nms_rad=self.damping_Nms_rad * torque_ratio / speed_ratio,
            nominal_voltage_V=voltage_V,
            voltage_points=tuple((v, t / torque_ratio, s / speed_ratio) for v, t, s in self.voltage_points),
        )

    def _ratios(self, voltage_V: float) -> tuple[float, float]:
        points = self.voltage_points or tuple((self.nominal_voltage_V * k, k, k) for k in (0.5, 1.0, 1.5))
        if not points[0][0] <= voltage_V <= points[-1][0]:
            raise ValueError(f"supply voltage {voltage_V} V: allowed {points[0][0]:g} .. {points[-1][0]:g} V")
        for (v0, t0, s0), (v1, t1, s1) in itertools.pairwise(points):
            if voltage_V <= v1:
                part = (voltage_V - v0) / (v1 - v0)
                return t0 + (t1 - t0) * part, s0 + (s1 - s0) * part
        return points[-1][1], points[-1][2]


def least_inertia_kgm2(damping_Nms_rad: float, dt_s: float) -> float:
    """Return the least inertia that damping may brake: an explicit drive overshoots when damping x dt comes near it."""
    return damping_Nms_rad * dt_s / _MAX_BRAKING


@dataclass(frozen=True)
class SensorModel:
    """The sensors' errors: joint encoder steps and white noise of the pitch, both off by default."""

    encoder_counts_per_turn: int = 0
    pitch_noise_rad: float = 0.0


@dataclass(frozen=True)
class PlanarRobot:
    """The robot in its sagittal plane. Lengths in metres, angles in radians, masses in kilograms.

    ``torso`` is without the hip links; each of the four ``hip_mass_kg`` sits at its hip. ``calf_on_torso``:
    the calf's motor sits at the hip and drives the calf through a rod, so it sets the calf's angle to the
    torso (thigh + calf) and its reaction goes to the torso instead of the thigh.
    ``stand_pose_rad`` are twelve joint angles, the pose the robot starts in unless told otherwise.
    """

    name: str
    torso: Link
    hip_mass_kg: float
    thigh: Link
    calf: Link
    hip_x_m: tuple[float, float, float, float]
    thigh_length_m: float
    calf_length_m: float
    thigh_limits_rad: tuple[float, float]
    calf_limits_rad: tuple[float, float]
    thigh_servo: ServoModel
    calf_servo: ServoModel
    stand_pose_rad: tuple[float, ...]
    calf_on_torso: bool = False
    foot_radius_m: float = 0.012
    foot_friction: float = 0.9
    link_radius_m: float = 0.006
    body_friction: float = 0.4
    torso_half_length_m: float = 0.15
    torso_half_height_m: float = 0.035
    payload_height_m: float = 0.05
    payload_half_length_m: float = 0.06
    end_stop_Nm_rad: float = 60.0
    end_stop_Nms_rad: float = 1.2  # 20 ms of the stiffness, as the stops in space have (chosen)
    sensors: SensorModel = field(default_factory=SensorModel)

    def __post_init__(self) -> None:
        if len(self.stand_pose_rad) != JOINTS:
            raise ValueError(f"{self.name}: stand_pose_rad has {len(self.stand_pose_rad)} angles, must be {JOINTS}")
        for name in ("thigh_limits_rad", "calf_limits_rad"):
            low, high = getattr(self, name)
            if not low < high:
                raise ValueError(f"{self.name}: {name} = ({low}, {high}) must rise")
        for name in ("thigh_length_m", "calf_length_m", "foot_radius_m", "link_radius_m", "end_stop_Nm_rad"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{self.name}: {name} = {getattr(self, name)} must be above 0")
        if not self.end_stop_Nms_rad >= 0:
            raise ValueError(f"{self.name}: end_stop_Nms_rad = {self.end_stop_Nms_rad} must be 0 or more")

    @property
    def mass_kg(self) -> float:
        """Mass of the whole robot, without payload."""
        return self.torso.mass_kg + 4 * (self.hip_mass_kg + self.thigh.mass_kg + self.calf.mass_kg)

    @property
    def torso_with_hips(self) -> Link:
        """The torso and its four hip links as one body."""
        return combine([(self.torso, 0.0, 0.0)] + [(_point(self.hip_mass_kg), x, 0.0) for x in self.hip_x_m])

    def loaded_torso(self, payload_kg: float) -> Link:
        """Torso, hip links and a payload: a bar of ``payload_half_length_m`` at ``payload_height_m``."""
        if payload_kg < 0:
            raise ValueError(f"payload {payload_kg} kg: must not be negative")
        if payload_kg == 0:
            return self.torso_with_hips
        bar = Link(payload_kg, payload_kg * self.payload_half_length_m**2 / 3, 0.0, self.payload_height_m)
        return combine([(self.torso_with_hips, 0.0, 0.0), (bar, 0.0, 0.0)])


def _point(mass_kg: float) -> Link:
    """A mass without extent (its moment is a formal 1e-12 kg m2), at its joint."""
    return Link(max(mass_kg, 1e-12), 1e-12, 0.0, 0.0)


def combine(parts: list[tuple[Link, float, float]]) -> Link:
    """Return rigidly joined links, each with its joint's (x, z), as one link: parallel-axis theorem."""
    mass = sum(link.mass_kg for link, _, _ in parts)
    com_x = sum(link.mass_kg * (x + link.com_x_m) for link, x, _ in parts) / mass
    com_z = sum(link.mass_kg * (z + link.com_z_m) for link, _, z in parts) / mass
    inertia = sum(
        link.inertia_kgm2
        + link.mass_kg * ((x + link.com_x_m - com_x) ** 2 + (z + link.com_z_m - com_z) ** 2)
        for link, x, z in parts
    )
    return Link(mass, inertia, com_x, com_z)
