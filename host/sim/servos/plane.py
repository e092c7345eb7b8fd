"""The honest law of a servo as drives of the plane: each with its rotor, all on one battery."""

from collections.abc import Sequence
from dataclasses import replace

from sim2d.actuator import Given, Told
from sim2d.model import PLANAR_JOINTS, PlanarRobot

from ...robot.actuators import Servo
from ...robot.model import Robot
from .law import LEAST_PLAY_RAD, Battery, Figures, ServoLaw, honest_figures


class HonestServos:
    """The plane's eight drives in motor angles; ``most`` are the duties' limits, 0 .. 1, None without torque."""

    def __init__(self, plane: PlanarRobot, figures: Figures, calf_ratio: float, battery: Battery) -> None:
        self._figures = replace(figures, backlash_rad=max(LEAST_PLAY_RAD, figures.backlash_rad))
        self._ratio = [1.0, calf_ratio] * 4
        self._links_kg_m2 = [(link.inertia_kgm2 + link.mass_kg * (link.com_x_m**2 + link.com_z_m**2))
                             for link in (plane.thigh, plane.calf)] * 4  # fmt: skip
        self.battery = battery
        self.most: list[float | None] = [1.0] * PLANAR_JOINTS
        self.given_Nm = [0.0] * PLANAR_JOINTS
        self.limit_Nm = [figures.stall_Nm * battery.open_V / figures.voltage_V / ratio for ratio in self._ratio]
        self.put_back()

    def put_back(self) -> None:
        """Forget the rotors: the next call says where they are."""
        self.laws: list[ServoLaw] = []

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See sim2d.actuator.Actuator."""
        laws = self.laws = self.laws or self._placed(position_rad)
        share = self._figures.stall_Nm / self._figures.motor_stall_Nm
        for i, law in enumerate(laws):
            ratio = self._ratio[i]
            law.step(goal_rad[i] / ratio, self.most[i], position_rad[i] / ratio, speed_rad_s[i] / ratio, 0.0, dt_s)
            torque_Nm[i], self.given_Nm[i] = law.torque_Nm / ratio, law.motor_Nm * share / ratio
        self.battery.settle()

    def _placed(self, position_rad: Sequence[float]) -> list[ServoLaw]:
        return [ServoLaw(self._figures, at / ratio, link * ratio**2, self.battery)
                for at, ratio, link in zip(position_rad, self._ratio, self._links_kg_m2, strict=True)]  # fmt: skip


def honest_servos(robot: Robot, plane: PlanarRobot, voltage_V: float | None) -> tuple[PlanarRobot, HonestServos | None]:
    """Return a plane's robot whose links carry no rotors, and the drives that do; as it was, and None, if not honest.

    Of brushless joints the plane shows no play: their own drives are in host/sim/motor/walking.py.
    """
    servo, figures = robot.actuator, honest_figures(robot.actuator) if robot.simulation.honest else None
    if figures is None or not isinstance(servo, Servo):
        return plane, None
    volts = figures.voltage_V if voltage_V is None else voltage_V
    bare = replace(plane, **{key: replace(getattr(plane, key), armature_kgm2=0.0, coulomb_Nm=0.0)
                             for key in ("thigh_servo", "calf_servo")})  # fmt: skip
    return bare, HonestServos(plane, figures, robot.calf_drive.ratio, Battery(volts, servo.supply_ohm))
