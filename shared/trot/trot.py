"""One tick of the trot.

    measured -> speed, residuals -> steering -> legs in swing -> stance and swing feet -> joints -> goals

Raibert's footholds and the linear pendulum's capture point, from the legs' own odometry. Stance feet follow a velocity
field, so the body has no pose to fall behind; any error is gone with the next swing.
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

    sensed: sense_legs has already taken its joints, and put their feet into walk.measured. speed and pose: slewed,
    speeds within 2^18, lengths within 32767; all else that is wanted is in ``walk.wish``. Without measured joints, tilt
    or rates the state's ``known`` is 0, and the trot only follows its commands.
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
    """Set tilt and rates to level and still: if anything is not measured, neither is used."""
    sensed.tilt[ROLL] = 0
    sensed.tilt[PITCH] = 0
    sensed.turned.x = 0
    sensed.turned.y = 0
    sensed.turned.z = 0


@hot
def keep_past(walk: Trot) -> None:
    """Keep the planned feet, as if unhindered, and the stance legs until the joints have answered the goals."""
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
    """Return 1 when the trot may end in a stand: all feet stand, and each touched down since that command; else 0."""
    if walk.state.standing == LEGS and walk.state.still_q20 > _CYCLE_AND_HALF:
        return 1
    return 0
