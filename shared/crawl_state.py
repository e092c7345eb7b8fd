"""All that the crawl of one robot remembers, made beforehand: a tick allocates nothing."""

from .body import POSE_SIZE
from .crawl_layout import C_SIZE, K_SIZE
from .crawl_setup import crawl_setup
from .load import Load
from .params import JOINTS, LEGS, Params
from .runtime import zeros


class Crawl:
    """The crawl of one robot at one rate: its settings, state and scratch blocks. ``crawl_tick`` allocates nothing."""

    def __init__(self, params: Params):
        self.settings = zeros(K_SIZE)
        self.limbs = Params()
        self.state = zeros(C_SIZE)
        self.load = Load()
        self.weights = zeros(LEGS)
        self.point = zeros(2)
        self.pose = zeros(POSE_SIZE)
        self.level = zeros(POSE_SIZE)
        self.rotation = zeros(9)
        self.feet = zeros(JOINTS)
        self.hip_feet = zeros(JOINTS)
        self.reached = zeros(JOINTS)
        self.joints = zeros(JOINTS)
        self.measured = zeros(JOINTS)
        crawl_setup(params, self.settings, self.limbs)
