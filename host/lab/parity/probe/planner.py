"""shared/planner*.py: their parts in any state a command can bring about, and long walks of every gait."""

from shared.body.balance import balance_setup
from shared.body.compliance import sag_leg
from shared.body.feet import Feet
from shared.body.legs import legs_forward
from shared.body.params import Params
from shared.crawl.crawl import crawl_start
from shared.crawl.state import STILL
from shared.gait.gaits import GAIT_NAMES, GAITS
from shared.gait.table import MOVER_CRAWL, MOVER_TABLE
from shared.planner import follow, mover_choice, movers, planner, walk_crawl, walk_table, walk_trot, weight
from shared.planner import pose as planner_pose
from shared.planner import senses as planner_senses
from shared.planner import states as planner_states
from shared.planner import status as n
from shared.planner.command import MODE_STAND, MODE_WALK, Command
from shared.planner.planner import Planner
from shared.runtime import zeros
from shared.sense.sensed import Sensed

from .draw import BRAD, FLAG, INT30, SHARE, Range
from .draws import GAIT
from .probe import Pick, Probe, probe_with
from .robots import PARAMS
from .row import Row, clear

COMMAND = Command()
SENSED = Sensed()
VALID = SENSED.valid


def row_of(sensed: Sensed):
    """Return what is sensed as one row: tilt and whether it is valid, joints likewise, turning likewise."""
    return Row(sensed.tilt, (sensed.valid, 0), sensed.joints, (sensed.valid, 1), sensed.turned, (sensed.valid, 2))


SENSED_ROW = row_of(SENSED)
OWN_RATE = (PARAMS[0], PARAMS[3])  # each robot at the rate of its file
ROBOTS = [planner.Planner(params) for params in OWN_RATE]
GOAL = zeros(12)
ANSWERED = zeros(12)
HIP_FEET = Feet()
WAVES = zeros(24)
ANY_MODE = Range(-1, 5)
ANY_GAIT = Range(-1, len(GAIT_NAMES))
ANY_MOVER = Range(MOVER_TABLE, MOVER_CRAWL)
TROT_GAIT = GAIT_NAMES.index("trot")
CRAWL_GAIT = GAIT_NAMES.index("crawl")
USUAL = 200  # vectors of a function, for which a walk has all its ticks


def restart(robot: Planner):
    """Bring a planner back to its first tick: limp, nothing known."""
    trot = robot.trot
    own = (robot.reached, robot.hip_feet, robot.margin_feet, robot.weights, robot.joints_history, robot.tilt_history)
    own += (robot.sensed.valid, robot.sensed.tilt, robot.sensed.joints, robot.sensed.turned)
    own += (trot.state, trot.measured, trot.before, trot.residual_x, trot.residual_z, trot.joints)
    own += (trot.expected_x_q4, trot.expected_z_q4, trot.past_x, trot.past_z)
    own += (trot.early_contact, trot.stance, trot.load_q12, trot.feet, trot.command)
    own += (trot.lift_offs, trot.swing_top, trot.apex, trot.joints_before, trot.past_stance, trot.hip_feet)
    for block in (robot.status, robot.clock, robot.joints, robot.move, robot.leg_flags, robot.goal) + own:
        clear(block)
    robot.gait = robot.gaits[0]
    balance_setup(robot.params, robot.balance)
    robot.status.gaits = len(robot.gaits)
    planner_states.reset_motion(robot)


def _restart_all():
    clear(COMMAND)
    clear(SENSED.tilt)
    clear(SENSED.joints)
    clear(SENSED.turned)
    clear(VALID)
    for robot in ROBOTS:
        restart(robot)


def _any_wish(dice):
    """Any numbers in the command; mode and gait stay for a while."""
    if dice.below(30) == 0:
        COMMAND.mode = ANY_MODE.any(dice)
        COMMAND.gait = ANY_GAIT.any(dice)
    for axis in range(3):
        COMMAND.speed[axis] = INT30.any(dice)
    for axis in range(6):
        COMMAND.pose[axis] = INT30.any(dice)
    COMMAND.balance = dice.bits(1)
    COMMAND.height = INT30.any(dice) if dice.bits(1) else 0


def _any_sense(dice):
    """Joints mostly about where they were, or none would be believed; the rest anything."""
    for at in range(len(SENSED_ROW)):
        if at < 3 or at >= 15 or dice.bits(6) == 0:  # no joint
            SENSED_ROW[at] = BRAD.any(dice)
        else:
            SENSED_ROW[at] += dice.bits(7) - 64
    if dice.bits(3):  # mostly upright, or it would sit most of the time
        SENSED.tilt[0] >>= 4
        SENSED.tilt[1] >>= 4
    VALID.turned = dice.bits(1)
    VALID.tilt = dice.bits(1)
    VALID.joints = 1 if dice.bits(2) else 0


def _live(values, dice):
    """Let the drawn robot live three ticks of anything; what is probed then acts on that state."""
    robot: Planner = values[0]
    for _ in range(3):
        _any_wish(dice)
        _any_sense(dice)
        planner.plan(robot, COMMAND, SENSED)


def _live_in(values, dice):
    _live(values, dice)
    values[2] = n.RISING if values[2] else n.SITTING


def _live_about_to_lift(values, dice):
    """Any state, the feet carrying or not, mostly about to be believed; lifted or not."""
    _live(values, dice)
    robot: Planner = values[0]
    status = robot.status
    robot.odometry.carried_q12 = dice.bits(17) - 65536
    status.carries_weight = dice.below(3)
    status.feet_load_q12 = dice.bits(11) if dice.bits(2) else dice.bits(17) - 65536
    status.pose_moves = 0 if dice.bits(2) else 1
    robot.sensing.known = robot.params.delay_ticks + 4 - dice.bits(1)
    status.lifted = dice.bits(1)


def answer(robot: Planner, joints):
    """Write the joints, 12 brad, as they answer the goals of a while ago: legs that stand give under the weight."""
    params: Params = robot.params
    sensing = robot.sensing
    sent = (sensing.sent_at - params.delay_ticks & 15) * 12
    for joint in range(12):
        joints[joint] = sensing.sent[sent + joint] if sensing.known > params.delay_ticks else robot.joints[joint]
        ANSWERED[joint] = joints[joint]
    legs_forward(params, ANSWERED, WAVES, HIP_FEET)
    stand = sum([1 - (robot.status.swinging >> leg & 1) for leg in range(4)])
    for leg in range(4):
        for axis in range(3):
            HIP_FEET.legs[leg][axis] -= params.legs[leg].hip[axis]
        if robot.status.swinging >> leg & 1 == 0:
            sag_leg(params, leg, HIP_FEET, 0, 0, 4096 // stand, ANSWERED)
    for joint in range(12):
        joints[joint] += joints[joint] - ANSWERED[joint]


class Walk(Probe):
    """A long walk: stand up, then walk with commands that change, a noisy attitude, feet out of reach.

    A robot that feels its legs carries its weight, or it would take itself for lifted and stand. Where it still does,
    its driver tells it to stand, and it goes on.
    """

    is_walk = True

    def __init__(self, name, robot: Planner, gait, length) -> None:
        self.robot = robot
        self.length = length
        self.gait = gait
        watch = (robot.joints, robot.leg_flags, robot.status)
        Probe.__init__(self, robot, "tick:" + name, (COMMAND, SENSED), watch)

    def count(self, usual):
        return usual * self.length // USUAL

    def start(self):
        Probe.start(self)
        restart(self.robot)
        clear(COMMAND)
        COMMAND.gait = self.gait
        COMMAND.balance = 1
        VALID.tilt = 1
        VALID.joints = 1
        VALID.turned = 1
        clear(SENSED.joints)

    def draw(self, index, count):
        COMMAND.mode = MODE_STAND if index % 1000 > 800 or self.robot.status.lifted else MODE_WALK
        if index % 150 == 0:
            self.new_wish(index)
        for axis in range(2):
            SENSED.tilt[axis] += self.dice.bits(7) - 64 - (SENSED.tilt[axis] >> 4)
        if GAITS[self.gait][1] != MOVER_TABLE:
            for axis in range(3):
                SENSED.turned[axis] = self.dice.bits(9) - 256
            answer(self.robot, SENSED.joints)
            for joint in range(12):
                SENSED.joints[joint] += self.dice.bits(4) - 8

    def walks(self):
        """Return 1 if the robot walked in this tick, moved by its gait's own mover; else 0."""
        status = self.robot.status
        return 1 if status.state == n.WALKING and status.mover == GAITS[self.gait][1] else 0

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
        if self.gait == CRAWL_GAIT and index % 300 < 150:  # straight on, or it would not crawl
            COMMAND.speed.vx = params.speed_max.vx >> 1
            COMMAND.speed.vy = 0
            COMMAND.speed.wz = 0


ROBOT = Pick(*ROBOTS)
STATE = (ROBOTS[0].status, ROBOTS[1].status, ROBOTS[0].joints, ROBOTS[1].joints)
FEET = (ROBOTS[0].feet, ROBOTS[1].feet)
POSES = STATE + (ROBOTS[0].pose, ROBOTS[1].pose)
BELIEVED = STATE + (row_of(ROBOTS[0].sensed), row_of(ROBOTS[1].sensed))
RETREATS = (ROBOTS[0].backing_command, ROBOTS[0].retreat, ROBOTS[1].backing_command, ROBOTS[1].retreat)
TROTS = STATE + (ROBOTS[0].trot.state, ROBOTS[0].trot.feet, ROBOTS[1].trot.state, ROBOTS[1].trot.feet)


BALANCED = tuple([robot.balanced_pose for robot in ROBOTS])
_part = probe_with(watch=STATE, fit=_live, begin=_restart_all)


def _crawling(values, dice):
    """A crawl that has just begun or is about to, with any senses."""
    _live(values, dice)
    robot: Planner = values[0]
    crawl_start(robot.crawl, robot.sensing, robot.joints, robot.joints, 0, 0)
    robot.status.mover = MOVER_CRAWL
    if dice.bits(1):
        robot.crawl.stage.stage = STILL


def _backing_off(values, dice):
    """A trot that backs off from an edge; sometimes it has just stood long enough."""
    _live(values, dice)
    robot: Planner = values[0]
    mover_choice.back_off(robot)
    COMMAND.speed.vx = dice.bits(12)
    COMMAND.speed.vy = 0
    COMMAND.speed.wz = 0
    COMMAND.mode = MODE_WALK
    COMMAND.gait = TROT_GAIT if dice.bits(2) else CRAWL_GAIT
    if dice.bits(1):
        robot.status.state = n.STANDING
        robot.retreat.stopping = 1
        robot.retreat.stood_ticks = 0xFFFF


PARTS = (
    _part(planner, "move", (ROBOT, COMMAND, SENSED)),
    _part(mover_choice, "usual_mover", (ROBOT,), watch=()),
    _part(mover_choice, "choose_mover", (ROBOT, COMMAND, SENSED)),
    _part(mover_choice, "crawl_is_due", (ROBOT, COMMAND, SENSED), watch=STATE + RETREATS),
    _part(mover_choice, "held_up_for_good", (ROBOT,), watch=()),
    _part(mover_choice, "back_off", (ROBOT,), watch=STATE + RETREATS),
    _part(mover_choice, "backed_off", (ROBOT, COMMAND, SENSED), watch=STATE + RETREATS, fit=_backing_off),
    _part(movers, "change_mover", (ROBOT, ANY_MOVER)),
    _part(movers, "start_mover", (ROBOT, ANY_MOVER)),
    _part(movers, "tick_mover", (ROBOT, COMMAND, SENSED)),
    _part(movers, "stop_mover", (ROBOT,), fit=_crawling),
    _part(walk_table, "walk_table", (ROBOT, COMMAND, SENSED)),
    _part(walk_trot, "start_trot", (ROBOT,), watch=TROTS),
    _part(walk_trot, "walk_trot", (ROBOT, COMMAND, SENSED), watch=STATE + TROTS),
    _part(walk_trot, "follow_trot", (ROBOT, COMMAND), watch=POSES),
    _part(walk_trot, "stop_trot", (ROBOT,)),
    _part(walk_crawl, "start_crawl", (ROBOT,)),
    _part(walk_crawl, "walk_crawl", (ROBOT, COMMAND, SENSED), fit=_crawling),
    _part(walk_crawl, "crawl_on", (ROBOT, COMMAND, SENSED, BRAD, BRAD), fit=_crawling),
    _part(walk_crawl, "end_reason", (ROBOT, COMMAND), fit=_crawling),
    _part(walk_crawl, "stop_crawl", (ROBOT,), fit=_crawling),
    _part(planner, "plan", (ROBOT, COMMAND, SENSED)),
    _part(planner_states, "choose_state", (ROBOT, COMMAND, SENSED)),
    _part(planner_states, "begin_move", (ROBOT, SENSED, FLAG), fit=_live_in),
    _part(planner_states, "reset_motion", (ROBOT,), watch=STATE + FEET),
    _part(planner_states, "end_move", (ROBOT,)),
    _part(planner_states, "fold_at_sides", (ROBOT,), watch=(ROBOTS[0].goal, ROBOTS[1].goal)),
    _part(planner_states, "seat_feet", (ROBOT,), watch=FEET),
    _part(planner_states, "follow_joints", (ROBOT, SENSED)),
    _part(follow, "follow_command", (ROBOT, COMMAND, Range(0, 2)), watch=POSES),
    _part(walk_table, "stands", (ROBOT, FLAG), watch=STATE + FEET),
    _part(walk_table, "lift_height", (ROBOT, INT30), watch=()),
    _part(walk_table, "step_feet", (ROBOT, SHARE), watch=STATE + FEET),
    _part(walk_table, "next_cycle", (ROBOT, GAIT, FLAG, FLAG)),
    _part(follow, "hold_back", (ROBOT, COMMAND), watch=POSES),
    _part(planner_senses, "take_senses", (ROBOT, SENSED), watch=BELIEVED),
    _part(planner_senses, "reset_goals", (ROBOT, GOAL)),
    _part(planner_senses, "update_sensing", (ROBOT,)),
    _part(planner_senses, "update_odometry", (ROBOT,)),
    _part(planner_senses, "flag_odd", (ROBOT, Range(-1, 12))),
    _part(weight, "watch_weight", (ROBOT,), fit=_live_about_to_lift),
    _part(weight, "carried_load_q12", (ROBOT,), fit=_live_about_to_lift),
    _part(weight, "check_carries", (ROBOT,), fit=_live_about_to_lift),
    _part(weight, "stays_lifted", (ROBOT, ANY_MODE), fit=_live_about_to_lift),
    _part(planner_states, "watch_tilt", (ROBOT, SENSED, ANY_MODE)),
    _part(follow, "wanted_gait", (ROBOT, COMMAND)),
    _part(follow, "limit_to_both", (ROBOT, GAIT), watch=(ROBOTS[0].top_speed, ROBOTS[1].top_speed)),
    _part(walk_table, "within_speed", (ROBOT, GAIT), watch=()),
    _part(follow, "use_gait", (ROBOT, GAIT)),
    _part(planner_pose, "pose_legs", (ROBOT, COMMAND, SENSED)),
    _part(planner_pose, "add_balance", (ROBOT, COMMAND, SENSED), watch=BALANCED),
    _part(planner_pose, "write_margin", (ROBOT,)),
    _part(planner_pose, "solve_legs", (ROBOT, GOAL), watch=(GOAL,)),
)
WALKS = tuple(
    [
        Walk(GAIT_NAMES[gait] + ("" if robot == 0 else "-short"), ROBOTS[robot], gait, (5000, 1000)[robot])
        for robot in range(2)
        for gait in range(len(GAIT_NAMES))
    ]
)
PROBES = PARTS + WALKS
