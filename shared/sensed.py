"""What is sensed of the robot in a tick, as the core takes it."""

from .params import JOINTS
from .record import field, record
from .runtime import zeros


@record
class Valid:
    """Which of the senses may be used in this tick: 1, else 0."""

    tilt: int = field("", "1: roll and pitch are known")
    joints: int = field("", "1: the joints are known")
    turned: int = field("", "1: the turning rates are known")


class Sensed:
    """Attitude, joints and turning rates of one tick.

    ``tilt``: roll and pitch, brad. ``joints``: 12 brad, as measured. ``turned``: how far the body turned about x, y and
    z in this tick, without the gyroscope's bias, 2^-18 rad. ``valid`` says which of them may be used.
    """

    def __init__(self):
        self.valid = Valid()
        self.tilt = zeros(2)
        self.joints = zeros(JOINTS)
        self.turned = zeros(3)
