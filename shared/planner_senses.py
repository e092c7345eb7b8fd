"""What the adaptive trot is given to feel, and what is forgotten under a gait that feels nothing."""

from .adaptive import W_ACTIVE, W_ADVICE, W_RATES, W_TURNED, W_TWIST, feel_ground, feel_legs, sway_body
from .balance import BALANCE_PITCH, BALANCE_ROLL
from .fixed import saturate
from .ground import press_feet
from .planner_layout import (
    BLIND,
    N_ADVICE,
    N_FLAGS,
    S_ATTITUDE_OK,
    S_JOINTS,
    S_JOINTS_OK,
    S_PITCH,
    S_RATES,
    S_RATES_OK,
    S_ROLL,
)
from .runtime import hot, ptr32
from .sensing import M_KNOWN


@hot
def feel(planner, sensed) -> int:
    """Give the adaptive trot what is sensed: turning rates, legs, ground; BLIND if some is missing. Returns 0."""
    n = ptr32(planner.numbers)
    s = ptr32(sensed)
    w = ptr32(planner.felt)
    b = ptr32(planner.balance)
    roll = 0
    pitch = 0
    if s[S_ATTITUDE_OK]:
        roll = saturate(s[S_ROLL], -32768, 32767)
        pitch = saturate(s[S_PITCH], -32768, 32767)
    w[W_RATES] = s[S_RATES_OK]
    for axis in range(3):
        w[W_TURNED + axis] = 0
        if s[S_RATES_OK]:
            w[W_TURNED + axis] = saturate(s[S_RATES + axis], -0x8000, 0x7FFF)
    if s[S_ATTITUDE_OK] == 0 or s[S_RATES_OK] == 0 or s[S_JOINTS_OK] == 0:
        n[N_FLAGS] |= BLIND
    feel_legs(planner.params, planner.walk, sensed, S_JOINTS, s[S_JOINTS_OK], roll, pitch)
    feel_ground(planner.params, planner.walk, planner.steps, roll, pitch, b[BALANCE_ROLL], b[BALANCE_PITCH])
    n[N_ADVICE] = w[W_ADVICE]
    return 0


@hot
def relax(planner) -> int:
    """Under a table gait: forget what was measured, sway to the middle, footholds to level ground; return 0."""
    w = ptr32(planner.felt)
    m = ptr32(planner.sensing)
    n = ptr32(planner.numbers)
    n[N_ADVICE] = 0
    m[M_KNOWN] = 0
    if w[W_ACTIVE]:
        w[W_TWIST] = 0
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
        press_feet(planner.params, planner.steps, 0)
    return 0
