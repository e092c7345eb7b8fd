"""All that the planner of one robot remembers, allocated beforehand: a tick allocates nothing."""

from ..body.axes import Pose, Twist
from ..body.balance import Balance, balance_setup
from ..body.feet import Feet
from ..body.params import JOINTS, LEGS, Params
from ..crawl.crawl import Crawl
from ..gait.gaits import GAITS, gait_for
from ..gait.steps import Steps
from ..gait.table import Clock
from ..runtime import zeros
from ..sense.legs import MeasuredFeet, Sensing
from ..sense.odometry import Odometry
from ..sense.sensed import Sensed
from ..trot.state import Trot
from .command import Command
from .goals import ReadingHistory
from .handover import Fade
from .posture import Move
from .retreat import Retreat
from .status import Status


class PlannerState:
    """The blocks that the planner's parts read and write. ValueError if a gait can't fit the robot.

    more: further gaits, as entries like those of GAITS, which come first.
    """

    def __init__(self, params: Params, more: tuple = ()):
        self.params = params
        self.gaits = [gait_for(entry, params) for entry in GAITS + more]
        self.gait = self.gaits[0]
        self.top_speed = Twist()  # limits of the commanded speed
        self.status = Status()
        self.clock = Clock()
        self.speed = Twist()
        self.pose = Pose()
        self.balanced_pose = Pose()
        self.rotation = zeros(9)
        self.steps = Steps()
        self.move = Move()
        self.balance = Balance()
        self.measured_feet = MeasuredFeet()
        self.odometry = Odometry()
        self.trot = Trot(self.measured_feet, self.odometry)
        self.feet = Feet()  # lu in the body: the feet of a table gait
        self.reached = self.trot.hip_feet  # lu from the hips, for table gaits too
        self.leg_flags = self.trot.flags
        self.hip_feet = Feet()
        self.margin_feet = Feet()  # lu in the body: the feet from which the margin is found
        self.weights = zeros(LEGS)  # 1: the foot stands
        self.goal = zeros(JOINTS)  # brad, wanted; ``joints`` follow as fast as the motors can
        self.joints = zeros(JOINTS)
        self.sensed = Sensed()  # the believed part of what is sensed
        self.joints_history = ReadingHistory()
        self.tilt_history = ReadingHistory()
        self.sensing = Sensing()
        self.crawl = Crawl(params)
        self.fade = Fade()
        self.retreat = Retreat()
        self.backing_command = Command()  # the trot's command while it backs off
        self.status.gaits = len(self.gaits)
        balance_setup(params, self.balance)
