"""The gaits as tables: adding a gait is adding its name and its table at the end of _NAMED.

A table is a head and a row per segment of the cycle:

    head     swing height mm, P_T and P_N of the swing in 1/100 (100, 100 = even samples),
             body profile in moving segments: 0 even, 1 cycloid
    segment  duration ms, legs in swing (bits: FR 1, FL 2, RR 4, RL 8), share of the body's
             advance made in it

A leg swings for as long as its bit stays set in consecutive segments; shares are relative. A
segment that moves the body while legs swing needs the even profile.
"""

from ..runtime import const

_FR = const(1)
_FL = const(2)
_RR = const(4)
_RL = const(8)

# Paper A, section 3.3: half a stride of the body, one diagonal, half a stride, the other, 0.5 s each,
# 0.05 m high, re-timed with P_T = 0.66 and P_N = 0.33.
PAPER_TROT = (
    (50, 66, 33, 1),
    ((500, 0, 1), (500, _FR | _RL, 0), (500, 0, 1), (500, _FL | _RR, 0)),
)

# The same order without the pauses: the body moves evenly all the time, each diagonal half a cycle.
TROT = (
    (35, 100, 100, 0),
    ((240, _FR | _RL, 1), (240, _FL | _RR, 1)),
)

# One leg at a time, hind legs leading on each side (RL, FL, RR, FR), three feet always down.
CRAWL = (
    (40, 100, 100, 0),
    (
        (200, 0, 1),
        (400, _RL, 2),
        (200, 0, 1),
        (400, _FL, 2),
        (200, 0, 1),
        (400, _RR, 2),
        (200, 0, 1),
        (400, _FR, 2),
    ),
)

# The adaptive trot at its slow speed; shared/trot/trot.py re-times it. While a diagonal swings the body moves at half
# its mean speed. P_T = P_N = 0: even samples of which the last is the foothold.
ADAPTIVE = (
    (35, 0, 0, 0),
    ((360, 0, 46), (200, _FR | _RL, 10), (360, 0, 46), (200, _FL | _RR, 10)),
)

# "climb", the crawl over obstacles (shared/crawl), goes straight on; what it cannot follow is walked by its table.
# The order is what commands count by: new gaits go to the end.
_NAMED = (
    ("paper-trot", PAPER_TROT),
    ("trot", TROT),
    ("crawl", CRAWL),
    ("adaptive", ADAPTIVE),
    ("climb", CRAWL),
)
GAIT_NAMES = tuple([row[0] for row in _NAMED])
GAITS = tuple([row[1] for row in _NAMED])
GAIT_ADAPTIVE = const(3)
GAIT_CLIMB = const(4)
