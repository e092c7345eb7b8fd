"""The figures to reach, for any robot: from its table in goals.toml, else from the general one, by the robot's size.

Most are in space. The group `plane` has the figures of the same gait in the plane.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from sim2d.model import GRAVITY_M_S2

from ...control.planner import Driver
from ...robot.ability import ability
from ...robot.model import KNEE_CONFIGURATIONS, Robot
from ...sim.grounds import GroundSpec, make_terrain
from ...sim.walk import Push, WalkSpec
from ...util.errors import UserError
from .case import Case, Experiment, Found, Judge, Row, stays_up
from .counts import LIMIT_S, load_specs, slope_specs, step_specs
from .data import assumptions, goal_tables
from .trials import FRICTIONS, PLANE, SPACE, STRIDE_M, Answer, Options, Trial, trials
from .verdicts import carries, share, sum_up, within

SPEED_SHARE = 0.05  # how far a speed may be off its command
TILT_DEG, YAW_DEG, SIDE_M = 5.0, 2.0, 0.03  # peak to peak; the last two per 1.5 m
STEADY_S = 12.0  # a walk on level ground: longer than twice START_S, which the steady figures leave out
STEP_START_M = 0.5  # so that the robot walks where the time over the edge begins
STEP_MEDIAN_S, HIGH_MEDIAN_S = 6.0, 30.0
DELAYS_S = ((0.02, True), (0.04, True), (0.06, True), (0.04, False), (0.06, False))  # and whether its file has it
PUSH_AT_S, PUSH_WATCH_S = 3.0, 4.0
STONES_M, PLANE_STONES_M = 0.020, 0.012
SLOPE_DEG = 10.0
STAIR_TREAD_M = 0.25


@dataclass(frozen=True)
class Wanted:
    """The goals of one robot, SI: see goals.toml."""

    flat_m_s: float
    aside_m_s: float
    back_m_s: float
    turn_rad_s: float
    climb_m_s: float
    stones_m_s: float
    step_m: float
    high_m: float
    stair_m: float
    pushed_m_s: tuple[float, ...]
    payloads_kg: tuple[float, ...]
    load_kg: float
    table: dict[str, Any]


def wanted(robot: Robot, gait: str) -> Wanted:
    """Return the goals of a robot."""
    tables = goal_tables()
    table = tables["general"] | tables.get(robot.name, {})
    froude_m_s = math.sqrt(GRAVITY_M_S2 * robot.stance.rest_height_m)
    leg_m = robot.geometry.thigh_m + robot.geometry.calf_m
    hip, foot = robot.hip_m(0), robot.foot_m(0, robot.stance.rest_height_m)
    flat_m_s = table.get("flat_m_s", min(table["flat_of_froude"] * froude_m_s, Driver(robot).speed_limit(gait)[0]))

    def either(key: str, whole: float, share_key: str) -> float:
        return float(table.get(key, table[share_key] * whole))

    return Wanted(
        flat_m_s, either("aside_m_s", flat_m_s, "aside_of_flat"), either("back_m_s", flat_m_s, "back_of_flat"),
        either("turn_rad_s", flat_m_s / math.hypot(hip[0] + foot[0], hip[1] + foot[1]), "turn_of_flat"),
        either("climb_m_s", froude_m_s, "climb_of_froude"), either("stones_m_s", froude_m_s, "stones_of_froude"),
        either("step_m", leg_m, "step_of_leg"), either("high_m", leg_m, "high_of_leg"),
        either("stair_m", leg_m, "stair_of_leg"),
        tuple(table.get("pushed_m_s", [part * flat_m_s for part in table["pushed_of_flat"]])),
        tuple(table.get("payloads_kg", [part * robot.mass_kg for part in table["payloads_of_mass"]])),
        either("load_kg", robot.mass_kg, "load_of_mass"), table,
    )


Group = Callable[[Options, Wanted], list[Case]]


def _level(options: Options, speed: float, usual: int = 3, **more: Any) -> list[WalkSpec]:
    """Return walks on level ground, STEADY_S long, at both frictions."""
    asked = {"robot": options.robot, "distance_m": min(20.0, STEADY_S * speed), **more}
    return [WalkSpec(gait=options.gait, speed_m_s=speed, friction=friction, seed=seed, **asked)
            for _, friction, seed in options.starts(usual)]


def _case(name: str, specs: list[WalkSpec], limits: str, judge: Judge, where: str = SPACE) -> Case:
    return Case(name, {where: trials(where, specs)}, limits, judge)


def with_delay(robot: Robot, delay_s: float) -> Robot:
    """Return the robot whose file has this delay of its bus."""
    return robot.model_copy(update={"bus": robot.bus.model_copy(update={"delay_s": delay_s})})


def _about(speed: float, part: float = SPEED_SHARE) -> tuple[float, float]:
    return speed * (1 - part), speed * (1 + part)


def flat(options: Options, want: Wanted) -> list[Case]:
    """Return level ground at the speed wanted, with its cost, and at a third and a sixth of it."""
    speed = want.flat_m_s
    straight = partial(within, roll_range_deg=(0, TILT_DEG), pitch_range_deg=(0, TILT_DEG),
                       yaw_drift_deg=(-YAW_DEG, YAW_DEG), side_drift_m=(-SIDE_M, SIDE_M))
    limits = f"within 5 %, tilt {TILT_DEG:g} deg, yaw {YAW_DEG:g} deg, {1000 * SIDE_M:g} mm aside in 1.5 m"
    slow = [_case(f"flat at {part:.3g} m/s", _level(options, part), limits, straight(speed_m_s=_about(part)))
            for part in (speed / 3, speed / 6)]
    fast = _case(f"flat at {speed:.3g} m/s", _level(options, speed), limits, straight(speed_m_s=_about(speed)))
    most = want.table["cost_most"]
    cost = Case(f"cost of transport at {speed:.3g} m/s", fast.trials, f"at most {most:g}" if most else "",
                within(judged=bool(most), cost_of_transport=(0, most or math.inf)))
    return [fast, *slow, cost]


def conditions(options: Options, want: Wanted) -> list[Case]:
    """Return level ground under everyday variations.

    A delay of the bus that the robot file does not have is only reported: `caramelo identify` finds it.
    """
    speed, least = want.flat_m_s, want.table["conditions_least"]

    def case(name: str, known: bool = True, **more: Any) -> Case:
        judge = within(least, known and bool(least), speed_m_s=_about(speed), roll_range_deg=(0, TILT_DEG),
                       pitch_range_deg=(0, TILT_DEG))
        limits = f"within 5 %, tilt {TILT_DEG:g} deg" if known else ""
        return _case(f"flat at {speed:.3g} m/s, {name}", _level(options, speed, **more), limits, judge)

    low = _level(options, speed / 6, voltage_V=options.robot.actuator.least_V, bus_delay_s=0.06)
    return [
        *(case(f"{1000 * delay_s:.0f} ms of bus delay, {'known' if known else 'unknown'}", known, bus_delay_s=delay_s,
               robot=with_delay(options.robot, delay_s) if known else options.robot) for delay_s, known in DELAYS_S),
        *(case(f"{volts:g} V", voltage_V=volts) for volts in want.table["voltages_V"]),
        *(case(f"{load_kg:.2g} kg of payload", payload_kg=load_kg) for load_kg in want.payloads_kg),
        _case(f"flat at {speed / 6:.3g} m/s, lowest voltage and 60 ms", low, "no fall", share(1.0)),
    ]


def ways(options: Options, want: Wanted) -> list[Case]:
    """Return sideways, turning and backwards."""
    part = want.table["ways_within"]
    asked = (("sideways", "left", want.aside_m_s, "m/s"), ("turning", "turn", want.turn_rad_s, "rad/s"),
             ("backwards", "back", want.back_m_s, "m/s"))
    return [_case(f"{name} at {speed:.3g} {unit}", _level(options, speed, way=way), f"within {100 * (1 - part):.3g} %",
                   within(speed_m_s=_about(speed, 1 - part))) for name, way, speed, unit in asked]


def at_a_trot(answer: Answer) -> bool:
    """Return whether a walk arrived without the crawl ever taking over."""
    return answer.ok and all(change["to"] != "crawl" for change in answer.figures["gait_changes"])


def steps(options: Options, want: Wanted) -> list[Case]:
    """Return steps at a trot, each kind."""
    least = want.table["step_least"]
    judge = share(least, at_a_trot, ("crossing_s", STEP_MEDIAN_S))
    limits = f"{100 * least:g} % at a trot, median {STEP_MEDIAN_S:g} s over the edge"
    return [_step(options, want, kind, want.step_m, limits, judge) for kind in ("up", "down", "over", "angled", "left")]


def _step(options: Options, want: Wanted, kind: str, height_m: float, limits: str, judge: Judge,
          where: str = SPACE) -> Case:
    specs = step_specs(options, kind, height_m, want.climb_m_s, start_m=STEP_START_M)
    return _case(f"{kind} {1000 * height_m:.0f} mm at {want.climb_m_s:.3g} m/s", specs, limits, judge, where)


def low(options: Options, want: Wanted) -> list[Case]:
    """Return steps of four fifths of the height, all of which the robot should pass in some way."""
    return [_step(options, want, kind, 0.8 * want.step_m, "all arrive", share(1.0)) for kind in ("up", "down", "over")]


def high(options: Options, want: Wanted) -> list[Case]:
    """Return steps for which the crawl is allowed."""
    least = want.table["high_least"] or None
    limits = f"{100 * least:g} %, median {HIGH_MEDIAN_S:g} s over the edge" if least else ""
    return [_step(options, want, kind, want.high_m, limits, share(least, most_median=("crossing_s", HIGH_MEDIAN_S)))
            for kind in ("up", "down")]


def bars(options: Options, want: Wanted) -> list[Case]:
    """Return bars across the way, 40 to 80 % of the step high."""
    specs = [spec for part in (0.4, 0.6, 0.8) for length_m in (0.03, 0.12)
             for spec in step_specs(options, "box", part * want.step_m, want.climb_m_s, 1, STEP_START_M, length_m)]
    return [_case("bars 40 .. 80 % of the step high, 30 and 120 mm deep", specs, "", share(None))]


def stairs(options: Options, want: Wanted) -> list[Case]:
    """Return eight steps up, and down."""
    least, found = want.table["stair_least"] or None, []
    for kind in ("up", "down"):
        specs = []
        for offset_m, friction, seed in options.starts(5):
            ground = GroundSpec(f"stairs-{kind}", want.stair_m, start_m=STEP_START_M + offset_m, length_m=STAIR_TREAD_M)
            specs.append(WalkSpec(options.robot, options.gait, want.climb_m_s, ground, friction=friction, seed=seed,
                                  distance_m=make_terrain(ground).finish_x_m or 1.0, limit_s=2 * LIMIT_S))
        found.append(_case(f"stairs of 8 steps of {1000 * want.stair_m:.0f} mm {kind}", specs,
                            f"{100 * least:g} %" if least else "", share(least)))
    return found


def pushes(options: Options, want: Wanted) -> list[Case]:
    """Return pushes from all sides, at all instants of a stride, of a robot that walks slowly and fast."""
    least, newton = want.table["push_least"] or None, want.table["push_m_s"] * options.robot.mass_kg / 0.1
    found = []
    for speed in want.pushed_m_s:
        spec, specs, count = WalkSpec(options.robot, options.gait, speed, distance_m=20.0), [], len(options.seeds(20))
        for offset_m, _, seed in options.starts(20)[:count]:
            turn = math.tau * offset_m / STRIDE_M
            push = Push(PUSH_AT_S + 0.5 * (0.618 * seed % 1), (newton * math.cos(turn), newton * math.sin(turn)))
            specs.append(replace(spec, seed=seed, push=push, limit_s=push.at_s + PUSH_WATCH_S))
        name = f"push of {want.table['push_m_s']:g} m/s at {speed:.3g} m/s"
        limits = f"{100 * least:g} % do not fall" if least else ""
        found.append(replace(_case(name, specs, limits, share(least, stays_up)), passes=stays_up))
    return found


def stones(options: Options, want: Wanted) -> list[Case]:
    """Return stones, another ground each."""
    spec = WalkSpec(options.robot, options.gait, want.stones_m_s, limit_s=LIMIT_S)
    specs = [replace(spec, seed=seed, ground=GroundSpec("stones", STONES_M, start_m=0.25, length_m=1.8, seed=seed),
                     friction=FRICTIONS[seed % 2]) for seed in options.seeds(10)]
    least = want.table["stones_least"]
    return [_case(f"stones of {1000 * STONES_M:g} mm at {want.stones_m_s:.3g} m/s", specs, f"{100 * least:g} %",
                   share(least))]


def _slopes(options: Options, want: Wanted, where: str, angle_deg: float, least: float | None) -> list[Case]:
    return [_case(f"slope of {angle_deg:g} deg {kind}", slope_specs(options, kind, angle_deg, 5, want.flat_m_s / 6),
                  "all arrive" if least else "", share(least), where) for kind in ("up", "down")]


def slopes(options: Options, want: Wanted) -> list[Case]:
    """Return slopes up and down."""
    return _slopes(options, want, SPACE, SLOPE_DEG, 1.0)


def load(options: Options, want: Wanted, where: str = SPACE) -> list[Case]:
    """Return 1.5 m with a load in each knee configuration; in the plane no joint may be above 40 % of stall.

    That is only reported of a robot that needs more to stand on its four legs with this load.
    """
    most = 1.0 if where == SPACE else assumptions()["payload"]["largest_torque_rms"]
    standing = max(ability(options.robot).on_four) * (1 + want.load_kg / options.robot.mass_kg)
    limits = (f"one knee configuration arrives, joints at most {100 * most:g} % of stall rms" if standing <= most
              else f"to stand with it takes {100 * standing:.0f} % of stall")
    walks = [Trial(load_specs(options, knees, want.load_kg)[0], where) for knees in KNEE_CONFIGURATIONS]
    return [Case(f"{want.load_kg:.3g} kg over 1.5 m", {where: walks}, limits, carries(most, standing <= most))]


def plane(options: Options, want: Wanted) -> list[Case]:
    """Return the goals in the plane."""
    case = partial(_case, where=PLANE)
    found = [case(f"flat at {speed:.3g} m/s", _level(options, speed), "within 5 %",
                  within(speed_m_s=_about(speed))) for speed in (want.flat_m_s, want.flat_m_s / 3, want.flat_m_s / 6)]
    spec = WalkSpec(options.robot, options.gait, want.flat_m_s / 6)
    rough = [replace(spec, seed=seed, ground=GroundSpec("stones", PLANE_STONES_M, length_m=spec.distance_m, seed=seed))
             for seed in options.seeds(10)]
    found.append(case(f"fixed stones of {1000 * PLANE_STONES_M:g} mm", rough, "pitch within 5 deg",
                      within(pitch_range_deg=(0, 5.0))))
    found += _slopes(options, want, PLANE, SLOPE_DEG, 1.0) + _slopes(options, want, PLANE, 15.0, None)
    for kind, height_m, least in (("up", 0.4 * want.step_m, 1.0), ("up", 0.8 * want.step_m, 1.0),
                                  ("up", want.step_m, 0.95), ("up", want.high_m, None),
                                  ("box", 0.8 * want.step_m, 1.0)):
        limits = f"{100 * least:g} %" if least else ""
        found.append(_step(options, want, kind, height_m, limits, share(least), PLANE))
    return found + load(options, want, PLANE)


GROUPS: dict[str, Group] = {group.__name__: group for group in (
    flat, conditions, ways, steps, low, high, bars, stairs, pushes, stones, slopes, load, plane)}


def cases(options: Options) -> list[Case]:
    """Return the cases of the groups asked for, or raise UserError; without MuJoCo those of the plane."""
    unknown = [name for name in options.only if name not in GROUPS]
    if unknown:
        raise UserError(f"--only {unknown[0]}: no such group of goals; there are {', '.join(GROUPS)}")
    names = options.only or tuple(GROUPS)
    want = wanted(options.robot, options.gait)
    return [replace(case, facts={"group": name}) for name in names if options.in_space or name == PLANE
            for case in GROUPS[name](options, want)]


def _sum_up(options: Options, rows: list[Row]) -> Found:
    return sum_up(f"Goals of {options.robot.name}, {'held-out' if options.held_out else 'chosen'} set", options, rows)


EXPERIMENT = Experiment("Figures to reach", cases, _sum_up)
