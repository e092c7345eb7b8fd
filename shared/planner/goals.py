"""The two ends of a tick: no goal moves faster than its joint can, and no single odd reading is believed.

    readings -> believed -> ... -> wanted goals -> at most the joint's speed from those sent last -> goals

Both apply in every state. In ordinary walking no reading is odd, and the speed limit only acts where a gait asks for
more than the joint has (the papers' trot, the first ticks of a swing).
"""

from ..body.params import CALF, JOINTS, THIGH, Params
from ..num.fixed import saturate
from ..record import field, record, vector
from ..runtime import Ints, const, hot

READ_NONE = const(0)  # no reading yet
READ_ONCE = const(1)  # one set of readings, believed only if the next set agrees with it
READ_SURE = const(2)
READ_ODD = const(3)  # some readings of the last set were odd


@record
class ReadingHistory:
    """Earlier readings, up to 12, that show which new ones are odd."""

    last_odd: Ints = vector(JOINTS, "brad", "the last set in which some were odd")
    state: int = field("", "READ_...")
    odd_in_row: int = field("ticks", "odd sets in a row")


_MOST_ODD = const(10)  # odd sets in a row after which nothing counts as known


@hot
def follow_goals(params: Params, wanted: Ints, joints: Ints) -> None:
    """Move ``joints`` (12 brad, sent last) towards ``wanted`` (12 brad), no motor faster than its top speed.

    Angles within +-32768. A calf motor on the body (paper B) turns thigh + calf, so its speed limits that sum. Every
    angle stays between where it was and where it is wanted, so goals within the joint limits stay within them. Exact.
    Intermediates: two sums of two angles, below 2^18.
    """
    most = params.joint_speed_safe
    least = -most
    for at in range(0, JOINTS, 3):
        hip = wanted[at] - joints[at]
        thigh = wanted[at + THIGH] - joints[at + THIGH]
        calf = wanted[at + CALF] - joints[at + CALF]
        if hip > most or hip < least or thigh > most or thigh < least or calf > most or calf < least:
            follow_leg(params, wanted, joints, at)
        else:
            joints[at] = wanted[at]
            joints[at + THIGH] = wanted[at + THIGH]
            joints[at + CALF] = wanted[at + CALF]


@hot
def follow_leg(params: Params, wanted: Ints, joints: Ints, at: int) -> None:
    """Move the three joints of one leg, which start at index ``at``, as follow_goals does.

    If the thigh's and the calf's motor are not equally fast, their difference would carry the calf off its way; then it
    keeps to it, and the thigh waits for the calf's motor.
    """
    top = params.joint_speed_max
    thigh = wanted[at + THIGH] - joints[at + THIGH]
    calf = wanted[at + CALF] - joints[at + CALF]
    step = saturate(thigh, -top.thigh, top.thigh)
    if params.coupled:
        gap = calf
        calf = saturate(thigh + calf, -top.calf, top.calf) - step
        if gap < 0:
            calf = saturate(calf, gap, 0)
        else:
            calf = saturate(calf, 0, gap)
        step = saturate(step, -top.calf - calf, top.calf - calf)
    else:
        calf = saturate(calf, -top.calf, top.calf)
    joints[at] += saturate(wanted[at] - joints[at], -top.hip, top.hip)
    joints[at + THIGH] += step
    joints[at + CALF] += calf


@hot
def joints_near(params: Params, readings: Ints, joints: Ints) -> int:
    """Return 1 if each of ``joints`` (12 brad) can get to its reading within one tick, else 0."""
    for joint in range(JOINTS):
        gap = readings[joint] - joints[joint]
        top = params.joint_speed_max[joint % 3]
        if gap > top or gap < -top:
            return 0
    return 1


@hot
def believe(readings: Ints, count: int, step: int, believed: Ints, history: ReadingHistory) -> int:
    """Copy ``count`` readings (at most 12) into ``believed``, except odd ones.

    Readings are limited to +-32768. A reading is odd if it differs by more than ``step`` from the believed value and
    from the reading before it; the believed value then stays. So a single odd reading never counts, and a change that
    lasts counts from its second tick on. The first set of all is believed when the next one agrees. Returns how many
    readings are odd, or -1 while nothing is known: at first, and after ten odd sets in a row. Intermediates: below
    2^17.
    """
    state = history.state
    odd = 0
    for at in range(count):
        reading = readings[at]
        was = believed[at]
        if reading != was:
            if reading > 32767 or reading < -32768:
                reading = saturate(reading, -32768, 32767)
            if reading > was + step or reading < was - step:
                odd += 1
            else:
                believed[at] = reading
    if state >= READ_SURE and odd:
        odd = believe_repeated(readings, count, step, believed, history)
    if odd == 0 and state != READ_NONE:
        history.state = READ_SURE
        history.odd_in_row = 0
        return 0
    if state >= READ_SURE and history.odd_in_row < _MOST_ODD:
        history.state = READ_ODD
        history.odd_in_row += 1
        return odd
    for at in range(count):
        believed[at] = saturate(readings[at], -32768, 32767)
    history.state = READ_ONCE
    history.odd_in_row = 0
    return -1


@hot
def believe_repeated(readings: Ints, count: int, step: int, believed: Ints, history: ReadingHistory) -> int:
    """Believe those odd readings that agree with the odd set just before; keep the set; return how many stay odd.

    Part of believe.
    """
    odd = 0
    for place in range(count):
        reading = saturate(readings[place], -32768, 32767)
        gap = reading - believed[place]
        if gap > step or gap < -step:
            again = reading - history.last_odd[place]
            if history.state == READ_ODD and again <= step and again >= -step:
                believed[place] = reading
            else:
                odd += 1
        history.last_odd[place] = reading
    return odd
