"""Writes measured numbers into a copy of a robot file; its comments and all else stay."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from ..robot.actuators import Servo
from ..robot.file import load_robot
from ..robot.rewrite import NewValue, rewritten
from ..util.files import read_text, write_text

# The comment of a key that the file lacks.
KEYS = {
    "actuator.duty_per_rad": "[1/rad] duty per error",
    "actuator.armature_kg_m2": "[kg m2] rotor inertia through the gear",
    "actuator.coulomb_Nm": "[N m] dry friction at the shaft",
    "actuator.backlash_deg": "[deg] play of the gears",
    "actuator.supply_ohm": "[ohm] battery and cables, at that stall_A",
    "actuator.friction.stribeck_Nm": "[N m] more at rest",
    "actuator.friction.stribeck_rad_s": "[rad/s] speed at which that fades",
    "actuator.friction.viscous_Nms_rad": "[N m s/rad] viscous friction",
    "actuator.friction.load_motor": "[-] friction by the motor's torque",
    "actuator.friction.load_external": "[-] friction by the load's torque",
    "bus.delay_s": "[s] from sending a goal until it acts, and from measuring until known",
}


@dataclass(frozen=True)
class Measure:
    """A number over the joints: its median, and how much they differ, as a share; None if only one was measured."""

    value: float
    spread: float | None = None

    def new(self, value: float, meaning: str, when: date) -> NewValue:
        """Return a value for the file, with four digits, and its source: when it was measured, and the spread."""
        spread = "" if self.spread is None else f", +-{100 * self.spread:.0f} % between joints"
        return NewValue(float(f"{value:.4g}"), meaning, f"{when.isoformat()}{spread}: measured")


def copy_with(source: Path, target: Path, servo: Servo, found: Mapping[str, Measure], when: date) -> None:
    """Write a copy of a robot file with the numbers found (write_checked).

    ``found`` goes by ``table.key``, as ``actuator.coulomb_Nm``; ``stall_Nm`` and ``no_load_rad_s`` scale all supply
    points alike.
    """
    values = {key: measure.new(measure.value, KEYS[key], when) for key, measure in found.items() if "." in key}
    for name, key, was in (
        ("stall_Nm", "stall_Nm", servo.nominal.stall_Nm), ("no_load_rad_s", "no_load_rpm", servo.nominal.no_load_rad_s)
    ):
        for number, point in enumerate(servo.supply if name in found else ()):
            value = getattr(point, key) * found[name].value / was
            values[f"actuator.supply.{number}.{key}"] = found[name].new(value, "", when)
    write_checked(source, target, values)


def write_checked(source: Path, target: Path, values: Mapping[str, NewValue]) -> None:
    """Write a copy of a robot file with these values, and check that it can be used; never leaves a bad copy."""
    text = rewritten(read_text(source), values, "measured")
    draft = target.with_name(f".{target.stem}.checked.toml")
    try:
        write_text(draft, text)
        load_robot(str(draft))
    finally:
        draft.unlink(missing_ok=True)
    write_text(target, text)
