"""shared/planner*.py: their parts in any state a command can bring about, and long walks of every gait."""

from shared import planner, planner_climb, planner_pose, planner_senses, planner_states, planner_steps
from shared import planner_layout as n
from shared.balance import balance_setup
from shared.command import (
    C_BALANCE,
    C_SPEED,
    COMMAND_SIZE,
    MODE_STAND,
    MODE_WALK,
    Command,
)
from shared.crawl import crawl_start
from shared.gaits import GAIT_ADAPTIVE, GAIT_CLIMB, GAIT_NAMES
from shared.params import Params
from shared.retreat import R_ENDS, R_STOOD
from shared.runtime import zeros

from .draw import Range
from .draws import BRAD, GAIT, INT30
from .probe import Pick, Probe
from .robots import PARAMS

SOURCES = ("planner", "planner_climb", "planner_pose", "planner_senses", "planner_states", "planner_steps")

COMMAND = Command()
SENSED = zeros(n.SENSED_SIZE)
OWN_RATE = (PARAMS[0], PARAMS[3])  # each robot at the rate of its file
ROBOTS = [planner.Planner(params) for params in OWN_RATE]
GOAL = zeros(12)
ANY_MODE = Range(-1, 4)
ANY_GAIT = Range(-1, len(GAIT_NAMES))
USUAL = 200  # vectors of a function, for which a walk has all its ticks


def restart(robot):
    """Bring a planner back to its first tick: limp, nothing known."""
    walk = robot.walk
    own = (walk.body, walk.firm, walk.stands, robot.drive, robot.reached)
    own += (robot.sensed, robot.joints_read, robot.tilt_read)
    for block in (robot.status, robot.clock, robot.joints, robot.move, robot.leg_flags, robot.goal) + own:
        for at in range(len(block)):
            block[at] = 0
    robot.gait = robot.gaits[0]
    balance_setup(robot.params, robot.balance)
    robot.status.gaits = len(robot.gaits)
    planner_states.settle(robot)


def _restart_all():
    for block in (COMMAND, SENSED):
        for at in range(len(block)):
            block[at] = 0
    for robot in ROBOTS:
        restart(robot)


def _any_wish(dice):
    """Any numbers in the command; mode and gait stay for a while."""
    if dice.below(30) == 0:
        COMMAND.mode = ANY_MODE.any(dice)
        COMMAND.gait = ANY_GAIT.any(dice)
    for at in range(C_SPEED, C_BALANCE):
        COMMAND[at] = INT30.any(dice)
    COMMAND.balance = dice.bits(1)
    COMMAND.height = INT30.any(dice) if dice.bits(1) else 0


def _any_sense(dice):
    """Joints mostly about where they were, or none would be believed; the rest anything."""
    for at in range(len(SENSED)):
        if at < n.S_JOINTS or at >= n.S_JOINTS_OK or dice.bits(6) == 0:
            SENSED[at] = BRAD.any(dice)
        else:
            SENSED[at] += dice.bits(7) - 64
    if dice.bits(3):  # mostly upright, or it would sit most of the time
        SENSED[n.S_ROLL] >>= 4
        SENSED[n.S_PITCH] >>= 4
    SENSED[n.S_RATES_OK] = dice.bits(1)
    SENSED[n.S_ATTITUDE_OK] = dice.bits(1)
    SENSED[n.S_JOINTS_OK] = 1 if dice.bits(2) else 0


def _live(values, dice):
    """Let the drawn robot live three ticks of anything; what is probed then acts on that state."""
    robot = values[0]
    for _ in range(3):
        _any_wish(dice)
        _any_sense(dice)
        planner.plan(robot, COMMAND, SENSED)


def _live_active(values, dice):
    _live(values, dice)
    values[0].walk.state.active = 1
    values[0].walk.state.sway = dice.bits(12) - 2048


def _live_in(values, dice):
    _live(values, dice)
    values[2] = n.RISING if values[2] else n.SITTING


# Made once: a tuple of public names is made anew wherever it stands.
TILT = (n.S_ROLL, n.S_PITCH)
FEELING = (GAIT_ADAPTIVE, GAIT_CLIMB)


class Walk(Probe):
    """A long walk: stand up, then walk with commands that change, a noisy attitude, feet out of reach."""

    def __init__(self, name, robot, gait, length) -> None:
        self.robot = robot
        self.length = length
        self.gait = gait
        watch = (robot.joints, robot.leg_flags, robot.status)
        Probe.__init__(self, "tick:" + name, robot.tick, (COMMAND, SENSED), watch=watch)

    def count(self, usual):
        return usual * self.length // USUAL

    def start(self):
        Probe.start(self)
        restart(self.robot)
        for at in range(COMMAND_SIZE):
            COMMAND[at] = 0
        COMMAND.gait = self.gait
        COMMAND.balance = 1
        SENSED[n.S_ATTITUDE_OK] = 1
        SENSED[n.S_JOINTS_OK] = 1
        SENSED[n.S_RATES_OK] = 1
        for joint in range(12):
            SENSED[n.S_JOINTS + joint] = 0

    def draw(self, index, count):
        COMMAND.mode = MODE_STAND if index % 1000 > 800 else MODE_WALK
        if index % 150 == 0:
            self.new_wish(index)
        for at in TILT:
            SENSED[at] += self.dice.bits(7) - 64 - (SENSED[at] >> 4)
        if self.gait in FEELING:
            for axis in range(3):
                SENSED[n.S_RATES + axis] = self.dice.bits(9) - 256
            for joint in range(12):
                SENSED[n.S_JOINTS + joint] = self.robot.joints[joint] + self.dice.bits(6) - 32

    def new_wish(self, index):
        """Another speed and pose, mostly in reach; every fifth time far outside what the legs reach."""
        params: Params = self.robot.params
        wild = index % 750 == 600
        for axis in range(3):
            top = params.speed_max[axis]
            COMMAND.speed[axis] = self.dice.below(2 * top + 1) - top
        for axis in range(6):
            top = params.pose_max[axis]
            top = top * 4 if wild else top // 6
            COMMAND.pose[axis] = self.dice.below(2 * top + 1) - top
        COMMAND.height = 12000 if wild else 0


ROBOT = Pick(*ROBOTS)
STATE = (ROBOTS[0].status, ROBOTS[1].status, ROBOTS[0].joints, ROBOTS[1].joints)
FEET = (ROBOTS[0].feet, ROBOTS[1].feet)
POSES = STATE + (ROBOTS[0].pose, ROBOTS[1].pose)
BELIEVED = STATE + (ROBOTS[0].sensed, ROBOTS[1].sensed)
RETREATS = (ROBOTS[0].retreat, ROBOTS[1].retreat)
WALKS_STATE = STATE + (ROBOTS[0].walk.state, ROBOTS[1].walk.state)


def _part(name, function, arguments, watch, fit=_live):
    return Probe(name, function, arguments, watch=watch, fit=fit, begin=_restart_all)


def _climbing(values, dice):
    """A crawl that has just begun, with any senses."""
    _live(values, dice)
    robot = values[0]
    crawl_start(robot.climb, robot.walk.sensing, robot.joints, 0, robot.joints, 0, 0)
    robot.status.climb = 1 + dice.bits(1)


def _backing_off(values, dice):
    """A trot that backs off from an edge; sometimes it has just stood long enough."""
    _live(values, dice)
    robot = values[0]
    planner_climb.back_off(robot)
    COMMAND.speed[0] = dice.bits(12)
    COMMAND.speed[1] = 0
    COMMAND.speed[2] = 0
    COMMAND.mode = MODE_WALK
    COMMAND.gait = GAIT_ADAPTIVE if dice.bits(2) else GAIT_CLIMB
    if dice.bits(1):
        robot.status.state = n.STANDING
        robot.retreat[R_ENDS] = 1
        robot.retreat[R_STOOD] = 0xFFFF


PARTS = (
    _part("tread", planner.tread, (ROBOT, COMMAND, SENSED), STATE),
    _part("climbs", planner_climb.climbs, (ROBOT, COMMAND, SENSED), STATE),
    _part("stop_to_climb", planner_climb.stop_to_climb, (ROBOT, GAIT), STATE),
    _part("back_off", planner_climb.back_off, (ROBOT,), STATE + RETREATS),
    _part("backed_off", planner_climb.backed_off, (ROBOT, COMMAND, SENSED), STATE + RETREATS, _backing_off),
    _part("advised", planner_climb.advised, (ROBOT, GAIT), STATE),
    _part("climb", planner_climb.climb, (ROBOT, COMMAND, SENSED), STATE, _climbing),
    _part("leaves", planner_climb.leaves, (ROBOT, COMMAND), STATE, _climbing),
    _part("hand_to_trot", planner_climb.hand_to_trot, (ROBOT, COMMAND, Range(0, 4)), STATE, _climbing),
    _part("plan", planner.plan, (ROBOT, COMMAND, SENSED), STATE),
    _part("choose_state", planner_states.choose_state, (ROBOT, COMMAND, SENSED), STATE),
    _part("begin_move", planner_states.begin_move, (ROBOT, SENSED, Range(0, 1)), STATE, _live_in),
    _part("settle", planner_states.settle, (ROBOT,), STATE + FEET),
    _part("fold_legs", planner_states.fold_legs, (ROBOT,), FEET),
    _part("follow_joints", planner_states.follow_joints, (ROBOT, SENSED), STATE),
    _part("step_gait", planner_steps.step_gait, (ROBOT, COMMAND), STATE + FEET),
    _part("hold_back", planner_steps.hold_back, (ROBOT, COMMAND), POSES),
    _part("take_senses", planner_senses.take_senses, (ROBOT, SENSED), BELIEVED),
    _part("meet", planner_senses.meet, (ROBOT,), STATE),
    _part("feel", planner_senses.feel, (ROBOT, SENSED), WALKS_STATE),
    _part("relax", planner_senses.relax, (ROBOT,), WALKS_STATE, _live_active),
    _part("watch_tilt", planner_states.watch_tilt, (ROBOT, SENSED, ANY_MODE), STATE),
    _part("walk_on", planner_steps.walk_on, (ROBOT, INT30, Range(0, 1)), STATE + FEET),
    _part("start_slowly", planner_steps.start_slowly, (ROBOT,), (ROBOTS[0].top, ROBOTS[1].top)),
    _part("wanted_gait", planner_steps.wanted_gait, (ROBOT, COMMAND), STATE),
    _part("crawl_waits", planner_steps.crawl_waits, (ROBOT, GAIT), STATE),
    _part("limit_to_both", planner_steps.limit_to_both, (ROBOT, GAIT), (ROBOTS[0].top, ROBOTS[1].top)),
    _part("use_gait", planner_steps.use_gait, (ROBOT, GAIT), STATE),
    _part("level", planner_pose.level, (ROBOT, COMMAND, SENSED), (ROBOTS[0].posed, ROBOTS[1].posed)),
    _part("solve_legs", planner_pose.solve_legs, (ROBOT, GOAL), (GOAL,)),
)
WALKS = tuple(
    [
        Walk(GAIT_NAMES[gait] + ("" if robot == 0 else "-short"), ROBOTS[robot], gait, (5000, 1000)[robot])
        for robot in range(2)
        for gait in range(len(GAIT_NAMES))
    ]
)
PROBES = PARTS + WALKS
