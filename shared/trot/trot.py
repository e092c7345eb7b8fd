"""The trot, one tick of it.

    measured -> speed, residuals -> steering -> who swings -> standing and swinging feet -> joints -> goals

Raibert's footholds and the linear pendulum's capture point, from the legs' own odometry; standing feet follow a field
of speeds, so that there is no pose to be behind of; whatever goes wrong is gone with the next swing.
"""

from ..body.axes import Pose, Twist
from ..body.leg import limit_legs
from ..body.params import LEGS, LF_BITS, Params
from ..runtime import Ints, const, hot
from ..sense.sensed import PITCH, ROLL, Sensed
from .clock import go_on
from .feel import feel
from .feet import stand_feet, swing_feet
from .ground import feel_slope
from .lead import lead, share_load, solve
from .react import lift_on
from .state import Trot, trot_reset
from .steer import lean, rise, steer

_CYCLE_AND_HALF = const(0x180000)


@hot
def trot_start(params: Params, walk: Trot) -> None:
    """Stand at rest, with nothing measured."""
    trot_reset(params, walk)
    solve(params, walk)


@hot
def trot_tick(params: Params, walk: Trot, sensed: Sensed, speed: Twist, pose: Pose, goal: Ints) -> int:
    """Plan one tick into ``goal`` (12 brad); return flags of legs out of reach or at their limits (reach.py, leg.py).

    sensed: its joints have been told to sense_legs, so that their feet are in walk.measured. speed and pose: slewed,
    speeds within 2^18, lengths within 32767; what else is wanted of it is in ``walk.wish``. Without measured joints,
    tilt or rates ``known`` is 0 in the state, and it goes by its commands.
    """
    valid = sensed.valid
    known = valid.joints & valid.tilt & valid.turned
    still = 0
    if speed.vx == 0 and speed.vy == 0 and speed.wz == 0:
        still = 1
    if known == 0:
        forget(sensed)
    feel(params, walk, sensed.turned, known)
    steer(params, walk, speed, sensed.turned, pose)
    lean(params, walk, sensed.tilt, sensed.turned, pose)
    if walk.state.known:
        feel_slope(params, walk)
    lift_on(params, walk)
    go_on(params, walk, still)
    rise(params, walk, pose)
    stand_feet(params, walk)
    if walk.state.swinging:
        swing_feet(params, walk, pose)
    keep_past(walk)
    flags = solve(params, walk)
    share_load(params, walk)
    lead(params, walk, goal)
    for leg in range(LEGS):
        walk.flags[leg] = 0
    return flags | limit_legs(params, goal, walk.flags)


@hot
def forget(sensed: Sensed) -> None:
    """Take tilt and rates that go with nothing else as level and still."""
    sensed.tilt[ROLL] = 0
    sensed.tilt[PITCH] = 0
    sensed.turned.x = 0
    sensed.turned.y = 0
    sensed.turned.z = 0


@hot
def keep_past(walk: Trot) -> None:
    """Keep the feet as if nothing hindered them, and who stands, for when the joints will have answered."""
    state = walk.state
    to = state.ring_at * LEGS
    for leg in range(LEGS):
        foot = walk.feet.legs[leg]
        ahead = foot.x >> LF_BITS
        if walk.stance[leg] == 0:
            ahead += walk.shortened[leg]
        walk.past_x[to] = ahead
        walk.past_z[to] = foot.z >> LF_BITS
        to += 1
    walk.past_stance[state.ring_at] = 15 - state.swinging
    state.ring_at = state.ring_at + 1 & 15


@hot
def trot_done(walk: Trot) -> int:
    """Return 1 when the trot may end in a stand: all feet stand, set down since the command is to stand; else 0."""
    if walk.state.standing == LEGS and walk.state.still_q20 > _CYCLE_AND_HALF:
        return 1
    return 0
