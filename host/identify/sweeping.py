"""Carries out sweeps: one joint in the air while its leg's others hold the rest pose; then all on the ground."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import asin, cos, degrees, pi, sin

from ..bus.base import JOINT_LABELS, JOINTS
from ..bus.dynamixel.calibration.data import limits_rad
from ..bus.dynamixel.link import ServoError
from ..robot.model import Robot
from ..robot.poses import leg_to_rad, rest_pose_rad, seated_pose_rad
from ..util.errors import UserError
from .carried import in_the_air, joint_per_shaft
from .plan import MOST, REACH_RAD, TICK_S, Sweep, plan
from .rig import Reading, Rig

GO_RAD_S = 0.6  # how fast a joint goes to where a sweep begins (chosen)
SETTLE_S = 0.3  # a joint that friction does not stop creeps to its goal with the lag, 0.04 s: 7 of these (chosen)
ARRIVED_RAD = 0.08  # further from its goal it is blocked: friction alone leaves 0.03 rad at the P gain in use (chosen)
GROUND_TICK_S = 0.02
GOLDEN = 0.618034  # shares of a tick at which joints are asked: multiples of it spread evenly, however many one takes
STRAIGHT = 0.97  # of a sway's wave: 0 is a sine, 1 a triangle, whose corners would shake the robot (chosen)
SHAKE_S, SHAKE_RAD = 2.0, 0.12
SHAKES = (0.1, 0.22, 0.34, 0.46)  # duties for shaking all joints, to draw current: out of step up to 3 A (seen)
SHAKE_TICKS = 5  # until a joint turns back

Done = Callable[[float], None]  # takes the completed share


@dataclass
class Trace:
    """One sweep as measured: commands with their times, and readings; times in s from its start."""

    joint: int
    name: str
    goal_rad: list[float] = field(default_factory=list)
    most: list[float] = field(default_factory=list)  # -1 without torque
    sent_s: list[float] = field(default_factory=list)
    asked_s: list[float] = field(default_factory=list)
    answered_s: list[float] = field(default_factory=list)
    position_rad: list[float] = field(default_factory=list)
    load: list[float] = field(default_factory=list)
    voltage_V: list[float] = field(default_factory=list)


@dataclass
class Stance:
    """One tick of all joints together; ``what`` is ``ground`` or ``shake``.

    At ``sent_s`` the joints were given their goals, with ``most`` as the limit of their duty; at ``at_s`` they were
    asked.
    """

    what: str
    sent_s: float
    goal_rad: list[float]
    most: float
    at_s: float
    position_rad: list[float]
    load: list[float]
    voltage_V: list[float]


class Blocked(ServoError):
    """A joint that does not reach the start of its sweep."""

    def __init__(self, joint: int, at_rad: float, goal_rad: float, ratio: float) -> None:
        self.joint = joint
        super().__init__(
            f"{JOINT_LABELS[joint]} stays at {degrees(at_rad * ratio):.0f} deg on its way to "
            f"{degrees(goal_rad * ratio):.0f}: blocked, or its sign in the calibration is wrong"
        )


def rest_shafts_rad(robot: Robot) -> list[float]:
    """Return the shafts' angles at rest, the centres of the sweeps."""
    return _shafts(robot, rest_pose_rad(robot))


def sweeps_of(robot: Robot, joint: int) -> list[Sweep]:
    """Return the sweeps of a joint, within its limits. UserError if they leave it too little room."""
    ratio, centre = joint_per_shaft(robot, joint), rest_shafts_rad(robot)[joint]
    low, high = (limit / ratio for limit in limits_rad(robot)[joint])
    reach = min(REACH_RAD, centre - low - 0.02, high - centre - 0.02)
    if reach < 0.25:
        raise UserError(
            f"{JOINT_LABELS[joint]}: {degrees(reach * ratio):.0f} deg from rest to its limits, at least 15 needed"
        )
    return plan(centre, reach, in_the_air(robot, joint))


def sweep_joint(rig: Rig, joint: int, done: Done = lambda share: None) -> list[Trace]:
    """Sweep one joint in the air and let go of its leg. Blocked if it does not reach the start of a sweep."""
    rest, leg = rest_shafts_rad(rig.robot), joint // 3 * 3
    sweeps = sweeps_of(rig.robot, joint)
    ends = [move.goal_rad for sweep in sweeps for move in sweep.moves]
    traces = []
    with _holding(rig, range(leg, leg + 3), MOST):
        _go(rig, {each: rest[each] for each in range(leg, leg + 3)}, joint)
        rig.allow(joint, min(ends), max(ends))
        for number, sweep in enumerate(sweeps):
            _go(rig, {joint: sweep.start_rad}, joint)
            traces.append(_play(rig, joint, sweep))
            done((number + 1) / len(sweeps))
    return traces


@contextmanager
def _holding(rig: Rig, joints: Sequence[int], most: float) -> Iterator[None]:
    """Let joints hold within their limits with a share of their stall torque; let go of all at the end."""
    for joint, limits in enumerate(limits_rad(rig.robot)):
        low, high = (limit / joint_per_shaft(rig.robot, joint) for limit in limits)
        rig.allow(joint, low, high)
    try:
        for joint in joints:
            rig.hold(joint, most)
        yield
    finally:
        rig.release()


def _go(rig: Rig, goals_rad: dict[int, float], looked_at: int) -> None:
    """Move joints together, slowly; then wait. Blocked if the watched joint does not arrive."""
    for joint in goals_rad:
        rig.limit(joint, MOST)
    now = _all(rig, list(goals_rad))
    far = max(abs(goal - now[joint].position_rad) for joint, goal in goals_rad.items())
    ticks = max(1, round(far / GO_RAD_S / TICK_S))
    due_s = rig.clock()
    for tick in range(ticks + round(SETTLE_S / TICK_S)):
        part = min(1.0, (tick + 1) / ticks)
        rig.tell({j: now[j].position_rad + part * (goal - now[j].position_rad) for j, goal in goals_rad.items()})
        rig.ask(list(goals_rad))
        due_s = _next(rig, due_s, TICK_S)
    at_rad = _all(rig, [looked_at])[looked_at].position_rad
    if abs(at_rad - goals_rad[looked_at]) > ARRIVED_RAD:
        raise Blocked(looked_at, at_rad, goals_rad[looked_at], joint_per_shaft(rig.robot, looked_at))


def _all(rig: Rig, joints: Sequence[int]) -> dict[int, Reading]:
    """Return readings of all these joints; asks until each has answered."""
    found: dict[int, Reading] = {}
    while len(found) < len(joints):
        found |= rig.ask([joint for joint in joints if joint not in found])
    return found


def _next(rig: Rig, due_s: float, tick_s: float) -> float:
    """Wait for the next tick; a late tick does not shorten the next ones."""
    due_s = max(due_s + tick_s, rig.clock())
    rig.wait_until(due_s)
    return due_s


def _play(rig: Rig, joint: int, sweep: Sweep) -> Trace:
    """Play one sweep's moves and record the joint's motion."""
    trace, moves = Trace(joint, sweep.name), list(sweep.moves)
    began_s = due_s = rig.clock()
    goal_rad = sweep.start_rad
    told: float | None = MOST
    for tick in range(round(sweep.duration_s / TICK_S)):
        while moves and moves[0].at_s <= tick * TICK_S + 1e-9:
            move = moves.pop(0)
            goal_rad = move.goal_rad
            if move.most != told:
                rig.limit(joint, move.most)
                told = move.most
        most = -1.0 if told is None else rig.rounded_share(told)
        sent_s = rig.clock() - began_s
        rig.tell({joint: goal_rad})
        reading = rig.ask([joint]).get(joint)
        if reading is not None:
            _note(trace, sent_s, began_s, rig.rounded_rad(joint, goal_rad), most, reading)
        due_s = _next(rig, due_s, TICK_S)
    return trace


def _note(trace: Trace, sent_s: float, began_s: float, goal_rad: float, most: float, reading: Reading) -> None:
    for values, value in (
        (trace.sent_s, sent_s), (trace.goal_rad, goal_rad), (trace.most, most),
        (trace.asked_s, reading.asked_s - began_s), (trace.answered_s, reading.answered_s - began_s),
        (trace.position_rad, reading.position_rad), (trace.load, reading.load), (trace.voltage_V, reading.voltage_V),
    ):  # fmt: skip
        values.append(round(value, 7))


def shake_all(rig: Rig, done: Done = lambda share: None) -> list[Stance]:
    """Shake all joints in the air, harder and harder; the current drawn shows how the supply sags.

    Each joint turns back a tick after the one before: together they draw an even current, whose voltage is seen in many
    steps of 0.1 V. In step they draw a short peak, and most of the time less than a step.
    """
    rest = rest_shafts_rad(rig.robot)
    rows: list[Stance] = []
    with _holding(rig, range(JOINTS), MOST):
        _go(rig, dict(enumerate(rest)), 0)
        for number, duty in enumerate(SHAKES):
            for joint in range(JOINTS):
                rig.limit(joint, duty)
            ticks = round(SHAKE_S / TICK_S / 2)
            for tick in range(ticks):
                sides = ((tick + joint) // SHAKE_TICKS % 2 * 2 - 1 for joint in range(JOINTS))
                goals = [at + side * SHAKE_RAD for at, side in zip(rest, sides, strict=True)]
                _tick(rig, "shake", goals, duty, rows, 2 * TICK_S)
            done((number + 1) / len(SHAKES))
    return rows


def stand_and_sway(rig: Rig, done: Done = lambda share: None) -> list[Stance]:
    """Stand up from sitting, sway slowly up and down, to and fro, sideways; sit down, let go."""
    robot, most, rows, waste = rig.robot, rig.robot.stand.torque_fraction, list[Stance](), list[Stance]()
    seated, rest = _shafts(robot, seated_pose_rad(robot)), rest_shafts_rad(robot)
    with _holding(rig, range(JOINTS), most):
        now = _all(rig, range(JOINTS))
        here = [now[joint].position_rad for joint in range(JOINTS)]
        for start, end, seconds in ((here, seated, 1.5), (seated, rest, 2.5)):
            _glide(rig, start, end, seconds, most, waste)
        goals = _sway(robot)
        for number, pose in enumerate(goals):
            _tick(rig, "ground", _shafts(robot, pose), most, rows, GROUND_TICK_S)
            done((number + 1) / len(goals))
        _glide(rig, _shafts(robot, goals[-1]), seated, 2.5, most, waste)
    return rows


def _shafts(robot: Robot, pose_rad: Sequence[float]) -> list[float]:
    return [angle / joint_per_shaft(robot, joint) for joint, angle in enumerate(pose_rad)]


def _glide(
    rig: Rig, start: Sequence[float], end: Sequence[float], seconds: float, most: float, rows: list[Stance]
) -> None:
    ticks = round(seconds / GROUND_TICK_S)
    for tick in range(ticks):
        part = 0.5 - 0.5 * cos(pi * (tick + 1) / ticks)
        goals = [a + part * (b - a) for a, b in zip(start, end, strict=True)]
        _tick(rig, "ground", goals, most, rows, GROUND_TICK_S)


def _tick(rig: Rig, what: str, goals: Sequence[float], most: float, rows: list[Stance], tick_s: float) -> None:
    """Command all joints, and ask them at another share of each tick: goals in steps make the duty a sawtooth.

    An answer may end after the tick: then the next goals go out later, so that no part of the sawtooth is left out.
    """
    due_s = rig.clock()
    rig.tell(dict(enumerate(goals)))
    told = [round(rig.rounded_rad(joint, goal), 7) for joint, goal in enumerate(goals)]
    rig.wait_until(due_s + tick_s * (len(rows) * GOLDEN % 1.0))
    read = rig.ask(range(JOINTS))
    if len(read) == JOINTS:
        rows.append(
            Stance(what, round(due_s, 6), told, rig.rounded_share(most), round(read[0].asked_s, 6), *(
                [round(getattr(read[joint], name), 7) for joint in range(JOINTS)]
                for name in ("position_rad", "load", "voltage_V")
            ))
        )  # fmt: skip
    _next(rig, due_s, tick_s)


def _sway(robot: Robot) -> list[list[float]]:
    """Return the poses of a body that moves slowly down and up, forward and back, left and right."""
    limits = robot.body_limits
    far = (min(0.03, 0.75 * limits.x_m), min(0.03, 0.75 * limits.y_m), min(0.03, 0.75 * limits.z_m))
    poses = []
    for axis, seconds in ((2, 8.0), (0, 8.0), (1, 8.0), (2, 5.0)):
        for tick in range(round(seconds / GROUND_TICK_S)):
            turn = 2 * pi * tick * GROUND_TICK_S / seconds * 2
            shift = [0.0, 0.0, 0.0]
            shift[axis] = far[axis] * _wave(turn) if axis < 2 else -far[axis] * (0.5 - 0.5 * _wave(turn + pi / 2))
            poses.append(_shifted(robot, shift))
    return poses


def _wave(turn_rad: float) -> float:
    """Return a sine with straight flanks: what accelerates seems to weigh more or less, and so do joints that turn."""
    return asin(STRAIGHT * sin(turn_rad)) / asin(STRAIGHT)


def _shifted(robot: Robot, shift_m: Sequence[float]) -> list[float]:
    pose: list[float] = []
    for leg in range(4):
        x, y, z = robot.foot_m(leg, robot.stance.rest_height_m)
        joints = leg_to_rad(robot, leg, (x - shift_m[0], y - shift_m[1], z - shift_m[2]))
        if joints is None:
            raise UserError(f"{robot.name}: leg {leg} can't follow the sway of the measurement")
        pose += joints
    return pose
