"""What is sensed of the robot in a tick, in the units of the core."""

from ..body.axes import Turn
from ..body.params import JOINTS
from ..record import field, pack, record
from ..runtime import Ints, const, zeros

ROLL = const(0)  # places in ``tilt``
PITCH = const(1)


@record
class Valid:
    """Which of the senses may be used in this tick."""

    tilt: int = field("", "1: roll and pitch are known")
    joints: int = field("", "1: the joints are known")
    turned: int = field("", "1: the turning rates are known")


class Sensed:
    """Attitude, joints and turning rates of one tick.

    ``tilt``: ROLL and PITCH, brad, an array like the joints, because one function checks both (planner/goals.py).
    ``joints``: 12 brad, as measured. ``turned``: how far the body turned in this tick, without the gyroscope's bias.
    ``valid`` says which of them may be used.
    """

    def __init__(self) -> None:
        self.valid = Valid()
        self.tilt = zeros(2)
        self.joints = zeros(JOINTS)
        self.turned = Turn()

    def pack(self) -> Ints:
        """Return its 20 integers as recordings keep them: tilt, joints, turned, each followed by its validity."""
        valid = self.valid
        return list(self.tilt) + [valid.tilt] + list(self.joints) + [valid.joints] + pack(self.turned) + [valid.turned]

    def unpack(self, integers: Ints) -> None:
        """Take what ``pack`` returned."""
        valid = self.valid
        self.tilt[ROLL], self.tilt[PITCH], valid.tilt = integers[:3]
        for joint in range(JOINTS):
            self.joints[joint] = integers[3 + joint]
        turned = self.turned
        valid.joints, turned.x, turned.y, turned.z, valid.turned = integers[3 + JOINTS :]
