"""All that the planner of one robot remembers, made beforehand: a tick allocates nothing."""

from .adaptive import Adaptive
from .balance import Balance, balance_setup
from .body import POSE_SIZE
from .crawl import Crawl
from .gait import G_ROWS, Clock, compile_gait
from .gaits import GAITS
from .goals import READ_SIZE
from .handover import FADE_SIZE
from .params import JOINTS, LEGS, Params
from .planner_layout import SENSED_SIZE, Status
from .posture import MOVE_SIZE
from .retreat import RETREAT_SIZE
from .runtime import zeros
from .steps import SPEED_SIZE, STEPS_SIZE


class PlannerState:
    """The blocks that the planner's parts read and write. ValueError if a gait can't fit the robot."""

    def __init__(self, params: Params):
        self.params = params
        self.gaits = [compile_gait(table, params) for table in GAITS]
        self.gait = self.gaits[0]
        self.top = zeros(G_ROWS)  # a gait's head, of which only the fastest speeds are used
        self.status = Status()
        self.clock = Clock()
        self.speed = zeros(SPEED_SIZE)
        self.drive = zeros(SPEED_SIZE)  # the speed that is walked: corrected by odometry
        self.pose = zeros(POSE_SIZE)
        self.posed = zeros(POSE_SIZE)
        self.rotation = zeros(9)
        self.steps = zeros(STEPS_SIZE)
        self.move = zeros(MOVE_SIZE)
        self.balance = Balance()
        self.feet = zeros(JOINTS)
        self.hip_feet = zeros(JOINTS)
        self.reached = zeros(JOINTS)
        self.goal = zeros(JOINTS)  # what is wanted of the joints; they go there as fast as they can
        self.joints = zeros(JOINTS)
        self.sensed = zeros(SENSED_SIZE)  # what is believed of what is sensed
        self.joints_read = zeros(JOINTS + READ_SIZE)
        self.tilt_read = zeros(2 + READ_SIZE)
        self.leg_flags = zeros(LEGS)
        self.walk = Adaptive(params)
        self.sensing = self.walk.sensing
        self.felt = self.walk.state
        self.load = self.walk.load
        self.nav = self.walk.nav
        self.climb = Crawl(params)
        self.fade = zeros(FADE_SIZE)
        self.retreat = zeros(RETREAT_SIZE)
        self.status.gaits = len(self.gaits)
        balance_setup(params, self.balance)
