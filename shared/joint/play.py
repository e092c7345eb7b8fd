"""The gear's play: how much farther the joint lags behind the rotor on the way there than on the way back.

Off-centre magnets and a gear ratio that is a little off act alike both ways. The play is found while the rotor creeps
to and fro (creeping.py): friction at the joint closes it then. A load that rattles, or a turn too short for the play to
close, hides a part of it and never adds to it, so the round that finds most counts. The result includes the angle by
which friction at the joint winds up the gear's spring, 2 F / k: the encoders cannot tell them apart.
"""

from ..num.fixed import ratio, saturate
from ..runtime import const, hot
from .commission_state import Commission, fail
from .encoder import wrap_count
from .faults import FAULT_COMMISSION_PLAY
from .layout import JointIo, JointSettings

_APART_MOST = const(8191)  # rc: half a rotor turn
_PLAY_MOST = const(91)  # a degree of the joint, of gear_q8 and for rc in Q4, times 32
_SUM_MOST = const(0x1FFFFFFF)


@hot
def follow_joint(io: JointIo, commission: Commission) -> None:
    """Add how far the joint has moved since the last call, less than half a turn."""
    commission.joint_moved += wrap_count(io.joint_raw - commission.joint_last)
    commission.joint_last = io.joint_raw


@hot
def add_play(settings: JointSettings, commission: Commission, way: int) -> None:
    """Add up joint encoder less rotor, times the rotor's ``way``, electrical-signed.

    The joint's counts grow up to 2^15 here, times a gear below 2^14: below 2^29. Ways of 2^15 in all, times 2^13: 2^28.
    """
    joint = commission.joint_moved
    if (commission.joint_moved_forward ^ commission.moved_forward) < 0:
        joint = -joint
    apart = saturate((joint * settings.gear_q8 >> 8) - commission.moved, -_APART_MOST, _APART_MOST)
    commission.play_sum = saturate(commission.play_sum + apart * way, -_SUM_MOST, _SUM_MOST)


@hot
def find_play(settings: JointSettings, commission: Commission) -> None:
    """At the end of a round find the play in rc of the rotor, Q4; the largest of all rounds counts."""
    if settings.has_joint_encoder == 0:
        return
    lag = 0 - commission.play_sum * commission.direction
    found = saturate(ratio(lag, saturate(commission.way, 1, 0x7FFFFF), 5), 0, _APART_MOST << 5)
    if found > commission.backlash:
        commission.backlash = found
    if commission.backlash > settings.gear_q8 * _PLAY_MOST >> 5:
        fail(commission, FAULT_COMMISSION_PLAY, commission.backlash >> 4)
