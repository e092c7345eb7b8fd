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
from .clock import advance_legs
from .estimate import estimate
from .feedforward import feed_forward, share_load, solve
from .feet import stand_feet, swing_feet
from .ground import choose_care, update_slope
from .react import choose_lift
from .state import Trot, trot_reset
from .steer import level_body, rise, steer

_CYCLE_AND_HALF = const(0x180000)


@hot
def trot_start(params: Params, trot: Trot) -> None:
    """Stand at rest, with nothing measured."""
    trot_reset(params, trot)
    solve(params, trot)


@hot
def trot_tick(params: Params, trot: Trot, sensed: Sensed, speed: Twist, pose: Pose, goal: Ints) -> int:
    """Plan one tick into ``goal`` (12 brad); return flags of legs out of reach or at their limits (reach.py, leg.py).

    sensed: sense_legs has already taken its joints, and put their feet into trot.measured. speed and pose: slewed,
    speeds within 2^18, lengths within 32767; all else that is wanted is in ``trot.command``. Without measured joints,
    tilt or rates the state's ``known`` is 0, and the trot only follows its commands.
    """
    valid = sensed.valid
    known = valid.joints & valid.tilt & valid.turned
    still = 0
    if speed.vx == 0 and speed.vy == 0 and speed.wz == 0:
        still = 1
    if known == 0:
        assume_level(sensed)
    estimate(params, trot, sensed.turned, known)
    steer(params, trot, speed, sensed.turned, pose)
    level_body(params, trot, sensed.tilt, sensed.turned, pose)
    if trot.state.known:
        update_slope(params, trot)
    choose_care(params, trot)
    choose_lift(params, trot)
    advance_legs(params, trot, still)
    rise(params, trot, pose)
    stand_feet(params, trot)
    if trot.state.swinging:
        swing_feet(params, trot, pose)
    keep_past(trot)
    flags = solve(params, trot)
    share_load(params, trot)
    feed_forward(params, trot, goal)
    for leg in range(LEGS):
        trot.flags[leg] = 0
    return flags | limit_legs(params, goal, trot.flags)


@hot
def assume_level(sensed: Sensed) -> None:
    """Set tilt and rates to level and still: if anything is not measured, neither is used."""
    sensed.tilt[ROLL] = 0
    sensed.tilt[PITCH] = 0
    sensed.turned.x = 0
    sensed.turned.y = 0
    sensed.turned.z = 0


@hot
def keep_past(trot: Trot) -> None:
    """Keep the planned feet, as if unhindered, and the stance legs until the joints have answered the goals."""
    state = trot.state
    to = state.ring_at * LEGS
    for leg in range(LEGS):
        foot = trot.feet.legs[leg]
        ahead = foot.x >> LF_BITS
        if trot.stance[leg] == 0:
            ahead += trot.shortened[leg]
        trot.past_x[to] = ahead
        trot.past_z[to] = foot.z >> LF_BITS
        to += 1
    trot.past_stance[state.ring_at] = 15 - state.swinging
    state.ring_at = state.ring_at + 1 & 15


@hot
def trot_done(trot: Trot) -> int:
    """Return 1 when the trot may end in a stand: all feet stand, and each touched down since that command; else 0."""
    if trot.state.standing == LEGS and trot.state.still_q20 > _CYCLE_AND_HALF:
        return 1
    return 0
