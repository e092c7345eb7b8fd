"""The papers' requirements, one case each: met or not, with the figure that decides."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from ...robot.actuators import Bldc, Servo
from ...robot.file import load_robot
from ...robot.model import KNEE_CONFIGURATIONS, Robot
from ...sim.walk import WalkSpec
from .case import Answers, Case, Experiment, Judge
from .counts import ANGLES_DEG, load_specs, slope_specs, step_specs
from .data import assumptions, papers
from .samples import walk_spec
from .trials import Options, Trial, most_loaded, trials
from .verdicts import carries, everywhere, share, sum_up

TRIALS = 3
STEP_M, STEP_SHARE = 0.05, 0.95
LOAD_KG = 2.0
JOINT_TORQUE_NM = 3.0
TORSO_KG = 3.0
OTHER_ROBOT, OTHER_SPEED_M_S = "parallel", 0.10
Walks = dict[str, list[Trial]]


def cases(options: Options) -> list[Case]:
    """Return the requirements in the papers' order."""
    def everywhere_of(specs: Callable[[str], list[WalkSpec]]) -> Walks:
        return {where: trials(where, specs(where)) for where in options.simulators}

    def course(terrain: str) -> Walks:
        return everywhere_of(lambda where: [walk_spec(options, terrain, where, seed) for seed in options.seeds(TRIALS)])

    flat, rough = course("flat"), course("stones")
    slopes = everywhere_of(lambda _: [spec for kind in ("up", "down")
                                      for spec in slope_specs(options, kind, ANGLES_DEG[0], 1)[:1]])
    steps = everywhere_of(lambda _: [spec for kind in ("up", "down") for spec in step_specs(options, kind, STEP_M)])
    loads = everywhere_of(lambda _: [load_specs(options, knees, LOAD_KG)[0] for knees in KNEE_CONFIGURATIONS])
    places = {where: flat[where] + rough[where] + slopes[where] for where in flat}
    other = load_robot(OTHER_ROBOT)
    torso = {"plane": [Trial(WalkSpec(other, other.gait.default, OTHER_SPEED_M_S))]}
    most = assumptions()["payload"]["largest_torque_rms"]
    asked: list[tuple[Walks, Judge]] = [
        (flat, partial(inspection, options.robot)), (rough, everywhere), (steps, _by_simulator(share(STEP_SHARE))),
        (places, everywhere), ({}, partial(_carried, options.robot)), (loads, carries(most)), ({}, _torque),
        (torso, _torso),
    ]
    return [Case(paper["name"], walks, judge=judge, paper=paper["paper"])
            for paper, (walks, judge) in zip(papers()["requirement"], asked, strict=True)]


def _by_simulator(judge: Judge) -> Judge:
    """Return a judge that asks another one of each simulator."""

    def both(answers: Answers) -> tuple[bool | None, str]:
        verdicts = {where: judge({where: series}) for where, series in answers.items()}
        told = ", ".join(f"{figure} {where}" for where, (_, figure) in verdicts.items())
        return all(met for met, _ in verdicts.values()), told

    return both


def inspection(robot: Robot, flat: Answers) -> tuple[bool, str]:
    """Judge time and energy for the area by the simulator in which it needs more, against the battery's energy."""
    found = []
    for where, walks in flat.items():
        arrived = [walk.figures for walk in walks if walk.ok]
        if not arrived:
            return False, f"does not walk on level ground ({where})"
        speed_m_s, power_W = (sum(float(row[key]) for row in arrived) / len(arrived)
                              for key in ("mean_speed_m_s", "power_W"))
        found.append({"simulator": where, **coverage(robot, speed_m_s, power_W)})
    data = max(found, key=lambda row: float(row["needed_Wh"]))
    return data["needed_Wh"] <= data["usable_Wh"], (
        f"{data['time_s'] / 60:.0f} min for {data['distance_m']:.0f} m of lanes {data['swath_m']:g} m wide; "
        f"{data['mean_power_W']:.1f} W, {data['needed_Wh']:.1f} Wh of {data['usable_Wh']:.1f} Wh usable of a "
        f"{data['battery']} ({data['simulator']})")


def coverage(robot: Robot, speed_m_s: float, power_W: float) -> dict[str, Any]:
    """Return time and energy for walking over the area, in lanes as wide as a camera sees, with turns between them."""
    job, battery = assumptions()["inspection"], _battery(robot)
    side_m = math.sqrt(job["area_m2"])
    lanes = math.ceil(side_m / job["swath_m"])
    turning_s = (lanes - 1) * math.pi / robot.speed_limits.wz_rad_s
    time_s = lanes * side_m / speed_m_s + turning_s
    return {
        "time_s": round(time_s), "distance_m": round(lanes * side_m, 1), "mean_power_W": round(power_W, 2),
        "needed_Wh": round(power_W * time_s / 3600, 2),
        "usable_Wh": round(battery["voltage_V"] * battery["capacity_Ah"] * battery["usable"], 2),
        "battery": battery["name"], "swath_m": job["swath_m"],
    }


def _battery(robot: Robot) -> dict[str, Any]:
    named: dict[str, Any] = assumptions()["battery"]["servo" if isinstance(robot.actuator, Servo) else "bldc"]
    return named


def _carried(robot: Robot, _: Answers) -> tuple[bool, str]:
    limit_kg = assumptions()["person"]["lift_kg"]
    mass_kg = robot.mass_kg + float(_battery(robot)["mass_kg"])
    return mass_kg <= limit_kg, f"{mass_kg:.2f} kg with its battery, of {limit_kg:g} kg"


def _torque(_: Answers) -> tuple[bool, str]:
    robot = load_robot(OTHER_ROBOT)
    if not isinstance(robot.actuator, Bldc):
        return False, f"robot {OTHER_ROBOT} has no brushless joints"
    torque_Nm, drive, gear = robot.actuator.torque_limit_Nm, robot.actuator.drive, robot.actuator.gear
    return torque_Nm >= JOINT_TORQUE_NM, f"{torque_Nm:.2f} N m at {drive.current_limit_A:g} A through {gear.ratio:g}:1"


def _torso(walks: Answers) -> tuple[bool, str]:
    torso_kg, (walk,) = load_robot(OTHER_ROBOT).links.trunk.mass_kg, walks["plane"]
    joint, part = most_loaded(walk.figures)
    return torso_kg < TORSO_KG and walk.ok, (
        f"{torso_kg:g} kg; at {OTHER_SPEED_M_S:g} m/s {'walks' if walk.ok else 'does not walk'} 1.5 m, "
        f"pitch range {walk.figures['pitch_range_deg']:.1f} deg, most loaded joint {joint} {100 * part:.0f} % rms")


EXPERIMENT = Experiment("The papers' requirements", cases, partial(sum_up, "Requirements"))
