"""The papers' requirements, one row each: met or not, with the figure it is judged by."""

import math
from typing import Any

from ...robot.actuators import Bldc, Servo
from ...robot.file import load_robot
from ...robot.model import KNEE_CONFIGURATIONS, Robot
from ...sim.export.ground import extrude
from ...sim.space.grounds import GroundSpec, make_ground
from ...sim.walk import WalkSpec
from . import payload, ramp, steps
from .data import assumptions, papers
from .outcome import Outcome, Table, rate
from .trials import Answer, Options, PlaneTrial, SpaceTrial, most_loaded, trial_conditions

TRIALS = 3
SPEED_M_S = 0.05
STEP_M = 0.05
STEP_SHARE = 0.95
LOAD_KG = 2.0
JOINT_TORQUE_NM = 3.0
TORSO_KG = 3.0
OTHER_ROBOT = "parallel"
OTHER_SPEED_M_S = 0.10

Tasks = list[PlaneTrial | SpaceTrial]


def groups(options: Options) -> dict[str, Tasks]:
    """Return the trials by what they are for, plane and space apart."""
    found: dict[str, Tasks] = {}
    for where in ("plane", "3-D") if options.in_space else ("plane",):
        for terrain in ("flat", "stones"):
            found[f"{terrain} {where}"] = [_walk(options, terrain, seed, where)
                                           for seed in range(options.count(TRIALS))]
        found[f"ramp {where}"] = [_ramp(options, kind, where) for kind in ramp.KINDS]
        found[f"steps {where}"] = [
            steps.trial(options, (where, kind, STEP_M), i, offset_m, friction)
            for kind in ("up", "down") for i, (offset_m, friction) in enumerate(steps.conditions(options))
        ]
        for knees in KNEE_CONFIGURATIONS:
            found[f"{knees} {where}"] = [payload.trial(options, knees, LOAD_KG, 0, where == "3-D")]
    other = load_robot(OTHER_ROBOT)
    found["other"] = [PlaneTrial(WalkSpec(other, other.gait.default, OTHER_SPEED_M_S))]
    return found


def _walk(options: Options, terrain: str, seed: int, where: str) -> PlaneTrial | SpaceTrial:
    spec = WalkSpec(options.robot, options.gait, SPEED_M_S, terrain,
                    **trial_conditions(options.robot, seed))  # type: ignore[arg-type]
    if where == "plane":
        return PlaneTrial(spec)
    return SpaceTrial(spec, make_ground(GroundSpec(terrain, seed=seed, start_m=0.25, length_m=1.8)))


def _ramp(options: Options, kind: str, where: str) -> PlaneTrial | SpaceTrial:
    ground = ramp.slope(ramp.ANGLES_DEG[0], kind)
    spec = WalkSpec(options.robot, options.gait, SPEED_M_S, distance_m=ground.finish_x_m or 1.5)
    return PlaneTrial(spec, ground) if where == "plane" else SpaceTrial(spec, extrude(ground))


def tasks(options: Options) -> Tasks:
    """Return all trials."""
    return [task for group in groups(options).values() for task in group]


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return one row for each requirement."""
    found: dict[str, list[Answer]] = {}
    at = 0
    for name, group in groups(options).items():
        found[name] = answers[at : at + len(group)]
        at += len(group)
    flat = {where: found[f"flat {where}"] for where in ("plane", "3-D") if f"flat {where}" in found}
    verdicts = [inspection(options.robot, flat), _irregular(found), _obstacles(found), _places(found),
                _carried(options.robot), _payload(found), _torque(), _torso(found["other"])]
    rows = [{"requirement": asked["name"], **verdict, "paper": asked["paper"]}
            for asked, verdict in zip(papers()["requirement"], verdicts, strict=True)]
    result = {"experiment": "requirements", "gait": options.gait, "requirements": rows}
    text = [(row["requirement"], "met" if row["met"] else "not met", row["figure"], row["paper"]) for row in rows]
    table = Table(f"Requirements, gait {options.gait}", ("", "here", "figure", "paper"), text)
    return Outcome("requirements", "The papers' requirements", result, [table])


def inspection(robot: Robot, flat: dict[str, list[Answer]]) -> dict[str, Any]:
    """Return time and energy for the area by the simulator in which it needs more, and what the battery holds."""
    found = []
    for where, walks in flat.items():
        arrived = [walk.figures for walk in walks if walk.ok]
        if not arrived:
            return {"met": False, "figure": f"does not walk on level ground ({where})", "data": {}}
        speed_m_s = sum(float(row["mean_speed_m_s"]) for row in arrived) / len(arrived)
        power_W = sum(float(row["power_W"]) for row in arrived) / len(arrived)
        found.append({"simulator": where, **coverage(robot, speed_m_s, power_W)})
    data = max(found, key=lambda row: float(row["needed_Wh"]))
    sentence = (f"{data['time_s'] / 60:.0f} min for {data['distance_m']:.0f} m of lanes {data['swath_m']:g} m wide; "
                f"{data['mean_power_W']:.1f} W, {data['needed_Wh']:.1f} Wh of {data['usable_Wh']:.1f} Wh usable of a "
                f"{data['battery']} ({data['simulator']})")
    return {"met": data["needed_Wh"] <= data["usable_Wh"], "figure": sentence, "data": data}


def coverage(robot: Robot, speed_m_s: float, power_W: float) -> dict[str, Any]:
    """Return what walking over the area takes, in lanes as wide as a camera sees, turning between them."""
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


def _all_ok(found: dict[str, list[Answer]], *names: str) -> bool:
    return all(answer.ok for name in names for answer in found.get(name, []))


def _irregular(found: dict[str, list[Answer]]) -> dict[str, Any]:
    plane, space = found["stones plane"], found.get("stones 3-D", [])
    pitch = max(float(answer.figures["pitch_range_deg"]) for answer in plane)
    sentence = f"stones of 12 mm: {rate(plane)} in the plane, pitch range {pitch:.1f} deg; {rate(space)} in 3-D"
    return {"met": _all_ok(found, "stones plane", "stones 3-D"), "figure": sentence,
            "data": {"pitch_range_deg": pitch}}


def _obstacles(found: dict[str, list[Answer]]) -> dict[str, Any]:
    shares = {where: sum(answer.ok for answer in series) / len(series) for where in ("plane", "3-D")
              if (series := found.get(f"steps {where}", []))}
    sentence = (f"5 cm steps up and down from all starts: {rate(found['steps plane'])} in the plane, "
                f"{rate(found.get('steps 3-D', []))} in 3-D")
    return {"met": all(share >= STEP_SHARE for share in shares.values()), "figure": sentence,
            "data": {"passed_share": shares}}


def _places(found: dict[str, list[Answer]]) -> dict[str, Any]:
    names = [f"{ground} {where}" for ground in ("flat", "stones", "ramp") for where in ("plane", "3-D")]
    parts = [f"{name}: {rate(found[name])}" for name in names if name in found]
    return {"met": _all_ok(found, *names), "figure": "walks on " + ", ".join(parts) + "; rain and dust are not judged",
            "data": {}}


def _carried(robot: Robot) -> dict[str, Any]:
    limit_kg = assumptions()["person"]["lift_kg"]
    mass_kg = robot.mass_kg + float(_battery(robot)["mass_kg"])
    return {"met": mass_kg <= limit_kg, "figure": f"{mass_kg:.2f} kg with its battery, of {limit_kg:g} kg",
            "data": {"mass_kg": round(mass_kg, 3)}}


def _payload(found: dict[str, list[Answer]]) -> dict[str, Any]:
    limit = assumptions()["payload"]["largest_torque_rms"]
    good, parts = [], []
    for knees in KNEE_CONFIGURATIONS:
        cases = [payload.verdict(found[f"{knees} {where}"]) for where in ("plane", "3-D")
                 if f"{knees} {where}" in found]
        if all(case["passed"] == case["trials"] and case["torque_rms_fraction"] <= limit for case in cases):
            good.append(knees)
        told = " and ".join(f"{'walks' if case['passed'] else 'fails'}, {100 * case['torque_rms_fraction']:.0f} %"
                            for case in cases)
        parts.append(f"{knees} {told}")
    sentence = f"2 kg over 1.5 m, largest joint torque rms of stall (plane and 3-D): {'; '.join(parts)}"
    return {"met": bool(good), "figure": sentence, "data": {"within_40_percent": good}}


def _torque() -> dict[str, Any]:
    robot = load_robot(OTHER_ROBOT)
    if not isinstance(robot.actuator, Bldc):
        return {"met": False, "figure": f"robot {OTHER_ROBOT} has no brushless joints", "data": {}}
    torque_Nm = robot.actuator.torque_limit_Nm
    drive, gear = robot.actuator.drive, robot.actuator.gear
    sentence = f"{torque_Nm:.2f} N m at {drive.current_limit_A:g} A through {gear.ratio:g}:1"
    return {"met": torque_Nm >= JOINT_TORQUE_NM, "figure": sentence, "data": {"torque_Nm": round(torque_Nm, 3)}}


def _torso(walks: list[Answer]) -> dict[str, Any]:
    torso_kg, figures = load_robot(OTHER_ROBOT).links.trunk.mass_kg, walks[0].figures
    joint, share = most_loaded(figures)
    sentence = (f"{torso_kg:g} kg; at {OTHER_SPEED_M_S:g} m/s {'walks' if walks[0].ok else 'does not walk'} 1.5 m, "
                f"pitch range {figures['pitch_range_deg']:.1f} deg, most loaded joint {joint} {100 * share:.0f} % rms")
    return {"met": torso_kg < TORSO_KG and walks[0].ok, "figure": sentence,
            "data": {"torso_kg": torso_kg, "pitch_range_deg": figures["pitch_range_deg"],
                     "torque_rms_fraction": share}}
