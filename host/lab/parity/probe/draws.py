"""Arguments that several modules of the core share: the robots, a leg, a foot anywhere, a gait of a robot."""

from shared.gait.gaits import GAITS, gait_for

from .draw import Range
from .probe import Pick
from .robots import PARAMS

INT30 = Range(-(1 << 30), (1 << 30) - 1)
HALF30 = Range(-(1 << 29), (1 << 29) - 1)
BRAD = Range(-32768, 32767)
LEG = Range(0, 3)
ROBOT = Pick(*PARAMS)
GAIT = Range(0, len(GAITS) - 1)

_COMPILED: list = [[None] * len(GAITS) for _ in PARAMS]


def gait_of(params, index):
    """Return the compiled gait ``index`` of the robot and rate that ``params`` is; made when first asked for."""
    for at in range(len(PARAMS)):
        if PARAMS[at] is params:
            if _COMPILED[at][index] is None:
                _COMPILED[at][index] = gait_for(GAITS[index], params)
            return _COMPILED[at][index]
    raise ValueError("not one of the robots")
