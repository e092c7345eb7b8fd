"""The whole robot, once a tick: command and senses in, twelve joint angles and flags out.

    command -> slew -> gait clock -> feet -> balance -> body pose -> 4 x leg -> limits -> joints

States: limp (nothing is driven), rising, standing, walking, sitting (going down), seated. A
command names a mode, and the planner goes there through the states between: nobody walks who has
not stood up first, and nobody sits down in mid-stride.
"""

from array import array

from .adaptive import (
    ADVICE_BEHIND,
    W_ACTIVE,
    W_ADVICE,
    W_AHEAD,
    W_BEHIND,
    W_FASTEST,
    W_LIFT,
    W_RATES,
    W_ROUGH,
    W_SWAY,
    W_TURNED,
    W_TWIST,
    Adaptive,
    adaptive_reset,
    adaptive_start,
    begin_segment,
    carry,
    drive_speed,
    feel_ground,
    feel_legs,
    learn_centre,
    pose_body,
    raise_body,
    sway_body,
)
from .balance import (
    BALANCE_PITCH,
    BALANCE_ROLL,
    BALANCE_SIZE,
    balance_gains,
    balance_release,
    balance_reset,
    balance_setup,
    balance_step,
)
from .body import POSE_PITCH, POSE_ROLL, POSE_SIZE, body_rotation, body_to_hip
from .command import (
    C_BALANCE,
    C_GAIT,
    C_HEIGHT,
    C_MODE,
    C_SPEED,
    MODE_LIMP,
    MODE_SIT,
    MODE_STAND,
    MODE_WALK,
    slew_pose,
    slew_speed,
)
from .compliance import sag_leg
from .crawl import Crawl, crawl_start, crawl_tick
from .crawl_layout import C_LEG, C_MARGIN, C_PHASE, C_STANDS, REST
from .fixed import saturate
from .gait import (
    CLOCK_MADE_Q10,
    CLOCK_SEGMENT,
    CLOCK_SIZE,
    CLOCK_TICK,
    G_HEIGHT_MM,
    G_ROWS,
    G_VX_MAX,
    compile_gait,
    gait_clock,
)
from .gaits import GAIT_ADAPTIVE, GAIT_CLIMB, GAITS
from .ground import press_feet
from .handover import (
    F_LEFT,
    FADE_SIZE,
    REASON_BEHIND,
    REASON_COMMAND,
    REASON_EVEN,
    REASON_NONE,
    fade_out,
    fade_start,
    ground_even,
    steps_from_crawl,
    straight_on,
)
from .leg import leg_inverse, limit_joints
from .load import L_FORCE_Q12
from .navigate import drive_as_told, navigate_reset
from .params import (
    JOINTS,
    LEG_HIP,
    LEG_SIZE,
    LEGS,
    P_KP_Q12,
    P_LENGTH_SHIFT,
    P_OWN_KP_Q12,
    P_POSE_SLEW,
    P_SENT_TICKS,
    P_SIT_Z,
    P_SIZE_BODY,
    P_STAND_TICKS,
    P_TILT_MAX,
    P_TILT_TICKS,
    P_VX_MAX,
    P_WZ_MAX,
)
from .posture import MOVE_SIZE, posture_start, posture_step
from .reach import reach_foot
from .retreat import RETREAT_SIZE, retreat_start, retreat_step
from .runtime import const, hot, ptr32
from .sensing import M_KNOWN, M_MOVED_X, keep_sent, sense_legs
from .steps import (
    SPEED_SIZE,
    STEPS_SIZE,
    body_advance,
    lift_at_once,
    move_feet,
    place_feet,
    start_swings,
    steps_at_rest,
    steps_reset,
)

LIMP = const(0)
RISING = const(1)
STANDING = const(2)
WALKING = const(3)
SITTING = const(4)
SEATED = const(5)
STATE_NAMES = ("limp", "rising", "standing", "walking", "sitting", "seated")

# What is sensed, one block
S_ROLL = const(0)  # brad
S_PITCH = const(1)
S_ATTITUDE_OK = const(2)  # 1: roll and pitch may be used
S_JOINTS = const(3)  # 12 brad, as measured
S_JOINTS_OK = const(15)  # 1: the measured joints may be used
S_RATES = const(16)  # 3 values: turn about x, y, z in this tick without the gyro's bias, 2^-18 rad
S_RATES_OK = const(19)  # 1: they may be used
SENSED_SIZE = const(20)

# Flags of a tick
REACH_FLAGS = const(0x07)  # a foot was out of reach: TOO_FAR, TOO_NEAR, INSIDE_HIP
LIMIT_FLAGS = const(0x38)  # a joint was at its limit: LIMIT_HIP, LIMIT_THIGH, LIMIT_CALF
NOT_DRIVEN = const(0x40)  # the joints are not to be held
NO_ATTITUDE = const(0x80)  # balance was asked for and there is no attitude
NO_JOINTS = const(0x100)  # standing up was asked for and the joints' positions are not known
BAD_COMMAND = const(0x200)  # a mode or gait that does not exist: taken as standing, as the last gait
BLIND = const(0x400)  # the adaptive trot lacks measured joints, attitude or turning rates: it walks on expectations
FALLEN = const(0x800)  # tilted too far for too long: it sits down, until told to sit or to be limp

# The planner's own numbers, one block
N_STATE = const(0)
N_GAIT = const(1)  # the gait being walked
N_HEIGHT = const(2)  # lu, its swing height
N_FLAGS = const(3)
N_SWINGING = const(4)  # legs in swing, bits
N_GAITS = const(5)  # how many gaits there are
N_CYCLES = const(6)  # 0 in the first cycle after standing
N_MARGIN = const(7)  # lu, static stability margin: the centre of mass in the polygon of the standing feet
N_ADVICE = const(8)  # ADVICE_... of the adaptive trot: whether another gait would do better
N_TILTED = const(9)  # ticks in a row of too much tilt
N_FALLEN = const(10)  # 1: fallen
N_CLIMB = const(11)  # the crawl over obstacles: CLIMB_...
N_REASON = const(12)  # why trot and crawl were last exchanged, handover.REASON_...
N_SIZE = const(13)

CLIMB_OFF = const(0)
CLIMB_READY = const(1)  # standing still until the joints' loads are known
CLIMB_ON = const(2)
CLIMB_BACK = const(3)  # the held-up trot backs off from the edge first
CLIMB_NAMES = ("off", "ready", "crawling", "backing off")


class Planner:
    """The control core of one robot at one rate.

    ``Planner(params)`` allocates all it needs; ``tick`` allocates nothing. After a tick read
    ``joints`` (12 brad), ``leg_flags`` (4), ``numbers`` (N_...), ``feet`` (12 lu, planned, in the
    base frame), ``reached`` (12 lu from the hips). Raises ValueError if a gait can't fit the robot.
    """

    def __init__(self, params):
        self.params = params
        self.gaits = [compile_gait(table, params) for table in GAITS]
        self.gait = self.gaits[0]
        self.top = array("i", [0] * G_ROWS)  # a gait's head, of which only the fastest speeds are used
        self.numbers = array("i", [0] * N_SIZE)
        self.clock = array("i", [0] * CLOCK_SIZE)
        self.speed = array("i", [0] * SPEED_SIZE)
        self.drive = array("i", [0] * SPEED_SIZE)  # the speed that is walked: corrected by odometry
        self.pose = array("i", [0] * POSE_SIZE)
        self.posed = array("i", [0] * POSE_SIZE)
        self.rotation = array("i", [0] * 9)
        self.steps = array("i", [0] * STEPS_SIZE)
        self.move = array("i", [0] * MOVE_SIZE)
        self.balance = array("i", [0] * BALANCE_SIZE)
        self.feet = array("i", [0] * JOINTS)
        self.hip_feet = array("i", [0] * JOINTS)
        self.reached = array("i", [0] * JOINTS)
        self.goal = array("i", [0] * JOINTS)
        self.joints = array("i", [0] * JOINTS)
        self.leg_flags = array("i", [0] * LEGS)
        self.walk = Adaptive(params)
        self.sensing = self.walk.sensing
        self.felt = self.walk.state
        self.load = self.walk.load
        self.nav = self.walk.nav
        self.climb = Crawl(params)
        self.fade = array("i", [0] * FADE_SIZE)
        self.retreat = array("i", [0] * RETREAT_SIZE)
        self.numbers[N_GAITS] = len(self.gaits)
        balance_setup(params, self.balance)
        settle(self)

    def tick(self, command, sensed):
        """Take a command (COMMAND_SIZE) and what is sensed (SENSED_SIZE), plan one tick; return the flags.

        Any 30-bit value in either block is survived: speeds and poses are limited, an unknown mode or
        gait sets BAD_COMMAND. Intermediates are those of the functions called.
        """
        return plan(self, command, sensed)


@hot
def plan(planner, command, sensed) -> int:
    """One tick of the planner; returns its flags."""
    n = ptr32(planner.numbers)
    n[N_FLAGS] = 0
    choose_state(planner, command, sensed)
    state = n[N_STATE]
    if state == LIMP:
        follow_joints(planner, sensed)
    elif state == RISING or state == SITTING:
        if posture_step(planner.move, planner.joints) == 0:
            n[N_STATE] = state + 1
    elif state != SEATED:
        if climbs(planner, command, sensed):
            climb(planner, command, sensed)
        elif n[N_CLIMB] == CLIMB_BACK:
            tread(planner, planner.retreat, sensed)
        else:
            tread(planner, command, sensed)
    return n[N_FLAGS]


@hot
def tread(planner, command, sensed) -> int:
    """One tick of standing or walking by a gait's table or the adaptive trot; return 0."""
    n = ptr32(planner.numbers)
    own = 0
    if n[N_GAIT] == GAIT_ADAPTIVE:
        own = 1
        feel(planner, sensed)
    step_gait(planner, command)
    level(planner, command, sensed)
    active = raise_body(planner.params, planner.walk, planner.reached, own)
    n[N_MARGIN] = carry(planner.params, planner.walk, planner.reached, n[N_SWINGING], own)
    if active:
        b = ptr32(planner.balance)
        pose_body(planner.params, planner.walk, b[BALANCE_ROLL], b[BALANCE_PITCH], planner.posed)
    n[N_FLAGS] |= solve_legs(planner, planner.joints)
    fade = ptr32(planner.fade)
    if fade[F_LEFT]:
        fade_out(planner.fade, planner.joints)
        for leg in range(LEGS):
            limit_joints(planner.params, leg, planner.joints)
    if own:
        keep_sent(planner.sensing, planner.joints)
    else:
        relax(planner)
    return 0


@hot
def climbs(planner, command, sensed) -> int:
    """Return 1 if this tick is the crawl's: it has begun, or is to begin now; else 0.

    It begins when it is the commanded gait and the command one it can follow, or when the adaptive trot is
    advised to stop, at a moment when all feet have stood for long enough; held up, the trot backs off first.
    Without measured joints or attitude it never begins (BLIND): its table is walked instead.
    """
    n = ptr32(planner.numbers)
    c = ptr32(command)
    s = ptr32(sensed)
    if n[N_CLIMB] == CLIMB_BACK:
        return backed_off(planner, command, sensed)
    if n[N_CLIMB]:
        return 1
    if c[C_MODE] != MODE_WALK or n[N_FALLEN] or straight_on(planner.params, command) == 0:
        return 0
    reason = REASON_NONE
    if n[N_SWINGING]:
        return 0
    if c[C_GAIT] == GAIT_CLIMB and (n[N_STATE] == STANDING or n[N_GAIT] == GAIT_CLIMB):
        reason = REASON_COMMAND
    elif c[C_GAIT] == GAIT_ADAPTIVE and n[N_GAIT] == GAIT_ADAPTIVE:
        reason = advised(planner)
    if reason == REASON_NONE:
        return 0
    if s[S_JOINTS_OK] == 0 or s[S_ATTITUDE_OK] == 0:
        n[N_FLAGS] |= BLIND
        return 0
    n[N_REASON] = reason
    if reason == REASON_BEHIND:
        return back_off(planner)
    return stop_to_climb(planner, c[C_GAIT])


@hot
def stop_to_climb(planner, gait: int) -> int:
    """Stand as the feet are; the crawl begins, as part of ``gait``, once the joints' loads are known; return 1."""
    n = ptr32(planner.numbers)
    v = ptr32(planner.speed)
    for axis in range(SPEED_SIZE):
        v[axis] = 0
    n[N_CLIMB] = CLIMB_READY
    n[N_GAIT] = gait
    return 1


@hot
def back_off(planner) -> int:
    """The held-up trot begins to back off, its reference where the robot is; return 0: it goes on trotting."""
    n = ptr32(planner.numbers)
    w = ptr32(planner.felt)
    navigate_reset(planner.nav)
    w[W_BEHIND] = 0
    n[N_CLIMB] = CLIMB_BACK
    return retreat_start(planner.retreat)


@hot
def backed_off(planner, command, sensed) -> int:
    """One tick of backing off; return 1 if it is done and the crawl takes over, 0 while the trot walks.

    It is given up when the command is no longer one for it, or when the senses it needs are missing.
    """
    n = ptr32(planner.numbers)
    c = ptr32(command)
    s = ptr32(sensed)
    m = ptr32(planner.sensing)
    keeps_on = straight_on(planner.params, command)
    if c[C_MODE] != MODE_WALK or c[C_GAIT] != GAIT_ADAPTIVE or n[N_FALLEN]:
        keeps_on = 0
    if keeps_on == 0 or s[S_JOINTS_OK] == 0 or s[S_ATTITUDE_OK] == 0:
        n[N_CLIMB] = CLIMB_OFF
        return 0
    standing = 0
    if n[N_STATE] == STANDING:
        standing = 1
    if retreat_step(planner.params, command, m[M_MOVED_X], standing, planner.retreat):
        return stop_to_climb(planner, GAIT_ADAPTIVE)
    return 0


@hot
def advised(planner) -> int:
    """Return why the adaptive trot should give way to the crawl, once all feet surely stand; else REASON_NONE.

    Tilt alone is no reason: a crawl begun with the feet on both sides of an edge down does not know where it is.
    """
    n = ptr32(planner.numbers)
    p = ptr32(planner.params)
    clock = ptr32(planner.clock)
    if n[N_STATE] == WALKING and clock[CLOCK_TICK] > p[P_STAND_TICKS] and n[N_ADVICE] == ADVICE_BEHIND:
        return REASON_BEHIND
    return REASON_NONE


@hot
def climb(planner, command, sensed) -> int:
    """One tick of the crawl over obstacles, or of what comes before and after it; return 0.

    While joints or attitude are missing the goals stay as they are. It is STANDING where the crawl rests.
    """
    n = ptr32(planner.numbers)
    s = ptr32(sensed)
    c = ptr32(command)
    p = ptr32(planner.params)
    m = ptr32(planner.sensing)
    at = ptr32(planner.climb.state)
    if s[S_JOINTS_OK] == 0 or s[S_ATTITUDE_OK] == 0:
        n[N_FLAGS] |= BLIND
        return 0
    roll = saturate(s[S_ROLL], -32768, 32767)
    pitch = saturate(s[S_PITCH], -32768, 32767)
    sense_legs(planner.params, sensed, S_JOINTS, roll, pitch, planner.sensing)
    if n[N_CLIMB] == CLIMB_READY and m[M_KNOWN] > p[P_SENT_TICKS] + 1:
        crawl_start(planner.climb, planner.sensing, sensed, S_JOINTS, planner.joints, roll, pitch)
        n[N_CLIMB] = CLIMB_ON
    if n[N_CLIMB] == CLIMB_ON:
        reason = leaves(planner, command)
        way = c[C_SPEED]
        if reason or c[C_MODE] != MODE_WALK or n[N_FALLEN]:
            way = 0
        n[N_FLAGS] |= crawl_tick(planner.climb, planner.sensing, sensed, S_JOINTS, roll, pitch, way, planner.joints)
        n[N_SWINGING] = 0
        if at[C_STANDS + at[C_LEG]] == 0:
            n[N_SWINGING] = 1 << at[C_LEG]
        n[N_MARGIN] = at[C_MARGIN]
        n[N_STATE] = WALKING
        if at[C_PHASE] == REST:
            if reason:
                hand_to_trot(planner, command, reason)
            elif way <= 0:
                n[N_STATE] = STANDING
    keep_sent(planner.sensing, planner.joints)
    return 0


@hot
def leaves(planner, command) -> int:
    """Return why the crawl is to end (handover.REASON_...), or REASON_NONE.

    Another gait is commanded, or a way it cannot go; as part of the adaptive gait also on even ground. A
    command of no speed at all lets it rest.
    """
    n = ptr32(planner.numbers)
    c = ptr32(command)
    wanted = wanted_gait(planner, command)
    if c[C_MODE] != MODE_WALK:
        return REASON_NONE
    if wanted != GAIT_CLIMB and wanted != GAIT_ADAPTIVE:
        return REASON_COMMAND
    if c[C_SPEED] == 0 and c[C_SPEED + 1] == 0 and c[C_SPEED + 2] == 0:
        return REASON_NONE
    if straight_on(planner.params, command) == 0:
        return REASON_COMMAND
    n[N_GAIT] = wanted
    if wanted == GAIT_ADAPTIVE and ground_even(planner.climb.state):
        return REASON_EVEN
    return REASON_NONE


@hot
def hand_to_trot(planner, command, reason: int) -> int:
    """End the crawl: the commanded gait walks on from where the feet stand, from rest; return 0."""
    n = ptr32(planner.numbers)
    w = ptr32(planner.felt)
    v = ptr32(planner.speed)
    steps_from_crawl(planner.params, planner.climb.state, w[W_AHEAD], w[W_SWAY], planner.steps)
    fade_start(planner.params, planner.fade, planner.joints)
    for axis in range(SPEED_SIZE):
        v[axis] = 0
    balance_reset(planner.balance)
    adaptive_start(planner.params, planner.walk)
    w[W_ROUGH] = 0
    n[N_CLIMB] = CLIMB_OFF
    n[N_REASON] = reason
    n[N_ADVICE] = 0
    n[N_CYCLES] = 0
    n[N_STATE] = WALKING
    return use_gait(planner, wanted_gait(planner, command))


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


@hot
def choose_state(planner, command, sensed) -> int:
    """Go where the commanded mode leads from the present state; return 0."""
    n = ptr32(planner.numbers)
    c = ptr32(command)
    mode = c[C_MODE]
    if mode < MODE_LIMP or mode > MODE_SIT:
        n[N_FLAGS] |= BAD_COMMAND
        mode = MODE_STAND
    state = n[N_STATE]
    if watch_tilt(planner, sensed, mode):
        n[N_FLAGS] |= FALLEN
        if mode != MODE_LIMP:
            mode = MODE_SIT
            if state == WALKING:
                begin_move(planner, sensed, SITTING)
    if mode == MODE_LIMP:
        n[N_STATE] = LIMP
        n[N_SWINGING] = 0
    elif mode == MODE_SIT:
        if state == STANDING or state == RISING:
            begin_move(planner, sensed, SITTING)
    elif state == LIMP or state == SEATED or state == SITTING:
        begin_move(planner, sensed, RISING)
    return 0


@hot
def watch_tilt(planner, sensed, mode: int) -> int:
    """Return 1 if the robot has fallen: tilted beyond its limit for so long, and not told to sit or to be limp since.

    Roll and pitch are looked at while it stands or walks and the attitude is known.
    """
    n = ptr32(planner.numbers)
    p = ptr32(planner.params)
    s = ptr32(sensed)
    if mode == MODE_LIMP or mode == MODE_SIT:
        n[N_FALLEN] = 0
    most = p[P_TILT_MAX]
    tilted = 0
    if s[S_ROLL] > most or s[S_ROLL] < -most or s[S_PITCH] > most or s[S_PITCH] < -most:
        tilted = n[N_TILTED] + 1
    if s[S_ATTITUDE_OK] == 0 or (n[N_STATE] != STANDING and n[N_STATE] != WALKING):
        tilted = 0
    n[N_TILTED] = tilted
    if tilted > p[P_TILT_TICKS]:
        n[N_FALLEN] = 1
        n[N_TILTED] = 0
    return n[N_FALLEN]


@hot
def begin_move(planner, sensed, state: int) -> int:
    """Start RISING to the rest stance or SITTING down from the measured joints; return 0.

    Without measured joints a limp robot stays limp (NO_JOINTS): its pose is anybody's guess. One
    that is driven goes on from its last goals.
    """
    n = ptr32(planner.numbers)
    s = ptr32(sensed)
    q = ptr32(planner.joints)
    if s[S_JOINTS_OK]:
        for joint in range(JOINTS):
            q[joint] = saturate(s[S_JOINTS + joint], -32768, 32767)
    elif n[N_STATE] == LIMP:
        n[N_FLAGS] |= NO_JOINTS
        return 0
    n[N_STATE] = state
    n[N_SWINGING] = 0
    settle(planner)
    if state == SITTING:
        fold_legs(planner)
    solve_legs(planner, planner.goal)
    posture_start(planner.params, planner.move, planner.joints, planner.goal)
    return 0


@hot
def settle(planner) -> int:
    """Forget all motion: feet at rest under a level body, speed 0; return 0."""
    v = ptr32(planner.speed)
    w = ptr32(planner.pose)
    posed = ptr32(planner.posed)
    for axis in range(SPEED_SIZE):
        v[axis] = 0
    for axis in range(POSE_SIZE):
        w[axis] = 0
        posed[axis] = 0
    fade = ptr32(planner.fade)
    fade[F_LEFT] = 0
    n = ptr32(planner.numbers)
    n[N_CLIMB] = CLIMB_OFF
    balance_reset(planner.balance)
    steps_reset(planner.params, planner.steps)
    adaptive_reset(planner.params, planner.walk)
    place_feet(planner.params, planner.gait, planner.steps, planner.speed, 0, planner.feet)
    return 0


@hot
def fold_legs(planner) -> int:
    """Raise all planned feet to the seat's height under the hips; return 0."""
    p = ptr32(planner.params)
    f = ptr32(planner.feet)
    for leg in range(LEGS):
        f[leg * 3 + 2] = p[P_SIZE_BODY + leg * LEG_SIZE + LEG_HIP + 2] + p[P_SIT_Z]
    return 0


@hot
def follow_joints(planner, sensed) -> int:
    """Limp: the goals are where the joints are, and nothing holds them; return 0."""
    n = ptr32(planner.numbers)
    s = ptr32(sensed)
    q = ptr32(planner.joints)
    n[N_FLAGS] |= NOT_DRIVEN
    if s[S_JOINTS_OK]:
        for joint in range(JOINTS):
            q[joint] = saturate(s[S_JOINTS + joint], -32768, 32767)
    return 0


@hot
def step_gait(planner, command) -> int:
    """Move the feet by one tick of the gait, and start or end walking where that is safe; return 0.

    The first cycle of a table gait is walked at half speed: all feet start at rest, in the middle of their
    way, and the last to swing would else be left a whole stride behind. The adaptive one starts slowly anyway.
    """
    n = ptr32(planner.numbers)
    c = ptr32(command)
    wanted = wanted_gait(planner, command)
    if n[N_STATE] == STANDING:
        use_gait(planner, wanted)
        n[N_CYCLES] = 0
    fits = limit_to_both(planner, wanted)
    halves = 0
    if c[C_MODE] == MODE_WALK and n[N_FALLEN] == 0:
        halves = 1
        if n[N_CYCLES] or n[N_GAIT] == GAIT_ADAPTIVE:
            halves = 2
    still = slew_speed(planner.params, planner.top, command, halves, planner.speed)
    slew_pose(planner.params, command, 1, planner.pose)
    if n[N_STATE] == STANDING:
        if still:
            place_feet(planner.params, planner.gait, planner.steps, planner.speed, 0, planner.feet)
            if n[N_GAIT] == GAIT_ADAPTIVE:
                sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
            return 0
        n[N_STATE] = WALKING
        adaptive_start(planner.params, planner.walk)
    walk_on(planner, c[C_HEIGHT], still)
    if gait_clock(planner.gait, planner.clock):
        n[N_CYCLES] = 1
        if still and steps_at_rest(planner.params, planner.steps):
            n[N_STATE] = STANDING
        elif fits:
            use_gait(planner, wanted)
        else:
            use_gait(planner, n[N_GAIT])
    return 0


@hot
def walk_on(planner, height_lu: int, still: int) -> int:
    """Move and place all feet for one tick of the gait's clock; return the legs in swing, bits.

    height: lift of a swing, lu; 0 or less: the gait's own. still: 1 while the commanded speed is 0.
    """
    n = ptr32(planner.numbers)
    p = ptr32(planner.params)
    w = ptr32(planner.felt)
    clock = ptr32(planner.clock)
    own = 0
    if height_lu <= 0:
        height_lu = n[N_HEIGHT]
    if n[N_GAIT] == GAIT_ADAPTIVE:
        own = 1
        height_lu = saturate(height_lu, 0, 32767) + w[W_LIFT]
    height_lu = saturate(height_lu, 0, -p[P_SIT_Z])
    if own and still == 0:
        drive_speed(planner.params, planner.walk, planner.speed, planner.drive)
    else:
        drive_as_told(planner.speed, planner.drive)
    if clock[CLOCK_TICK] == 0:
        if own:
            begin_segment(planner.params, planner.walk, planner.gait, planner.clock, planner.speed, planner.drive)
        start_swings(planner.gait, planner.clock, planner.steps)
        if own:
            lift_at_once(planner.steps, height_lu)
    move_feet(planner.steps, planner.drive, body_advance(planner.gait, planner.clock))
    n[N_SWINGING] = place_feet(planner.params, planner.gait, planner.steps, planner.drive, height_lu, planner.feet)
    if own:
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 1)
        learn_centre(planner.params, planner.walk, planner.clock)
    return n[N_SWINGING]


@hot
def limit_to_both(planner, wanted: int) -> int:
    """Take as the fastest command what the present gait and the ``wanted`` one both allow.

    Returns 1 if the present speed is within that of the wanted gait: a faster walk would step too far in it.
    """
    g = ptr32(planner.gait)
    w = ptr32(planner.gaits[wanted])
    n = ptr32(planner.numbers)
    v = ptr32(planner.speed)
    top = ptr32(planner.top)
    fits = 1
    for axis in range(SPEED_SIZE):
        most = w[G_VX_MAX + axis]
        if v[axis] > most or v[axis] < -most:
            fits = 0
        if g[G_VX_MAX + axis] < most:
            most = g[G_VX_MAX + axis]
        top[G_VX_MAX + axis] = most
    if n[N_GAIT] == GAIT_ADAPTIVE:
        start_slowly(planner)
    return fits


@hot
def start_slowly(planner) -> int:
    """Limit ``top`` to what the adaptive trot may do so soon after its start, turning in proportion; return 0.

    Intermediates: 2^18 turned down to 12 bits times 2^16.
    """
    p = ptr32(planner.params)
    w = ptr32(planner.felt)
    top = ptr32(planner.top)
    fastest = w[W_FASTEST]
    for axis in range(2):
        if top[G_VX_MAX + axis] > fastest:
            top[G_VX_MAX + axis] = fastest
    share_q10 = saturate((fastest << 10) // p[P_VX_MAX], 1, 1024)
    turn = (p[P_WZ_MAX] * share_q10 >> 10) + 1
    if top[G_VX_MAX + 2] > turn:
        top[G_VX_MAX + 2] = turn
    return 0


@hot
def wanted_gait(planner, command) -> int:
    """Return the index of the commanded gait, or of the present one if there is no such gait."""
    n = ptr32(planner.numbers)
    c = ptr32(command)
    gait = c[C_GAIT]
    if gait < 0 or gait >= n[N_GAITS]:
        n[N_FLAGS] |= BAD_COMMAND
        return n[N_GAIT]
    return gait


@hot
def use_gait(planner, gait: int) -> int:
    """Walk ``gait`` from its first segment on; only between cycles, when all feet stand. Returns 0."""
    n = ptr32(planner.numbers)
    p = ptr32(planner.params)
    clock = ptr32(planner.clock)
    clock[CLOCK_TICK] = 0
    clock[CLOCK_MADE_Q10] = 0
    clock[CLOCK_SEGMENT] = 0
    n[N_GAIT] = gait
    planner.gait = planner.gaits[gait]
    if gait == GAIT_ADAPTIVE:
        balance_gains(planner.params, P_OWN_KP_Q12, planner.balance)
    else:
        balance_gains(planner.params, P_KP_Q12, planner.balance)
    g = ptr32(planner.gait)
    n[N_HEIGHT] = (g[G_HEIGHT_MM] << p[P_LENGTH_SHIFT]) // 1000
    return 0


@hot
def level(planner, command, sensed) -> int:
    """Add balance to the slewed body pose; return 0. NO_ATTITUDE if it was asked for in vain."""
    n = ptr32(planner.numbers)
    c = ptr32(command)
    s = ptr32(sensed)
    p = ptr32(planner.params)
    pose = ptr32(planner.pose)
    posed = ptr32(planner.posed)
    b = ptr32(planner.balance)
    if c[C_BALANCE] and s[S_ATTITUDE_OK]:
        roll = saturate(s[S_ROLL], -32768, 32767)
        pitch = saturate(s[S_PITCH], -32768, 32767)
        balance_step(planner.balance, planner.pose, roll, pitch)
    else:
        balance_release(planner.balance, p[P_POSE_SLEW + POSE_ROLL])
        if c[C_BALANCE]:
            n[N_FLAGS] |= NO_ATTITUDE
    for axis in range(POSE_SIZE):
        posed[axis] = pose[axis]
    posed[POSE_ROLL] += b[BALANCE_ROLL]
    posed[POSE_PITCH] += b[BALANCE_PITCH]
    return 0


@hot
def solve_legs(planner, joints) -> int:
    """Solve all four legs for the planned feet and body pose into ``joints``; return the flags together."""
    per_leg = ptr32(planner.leg_flags)
    forces = ptr32(planner.load)
    body_rotation(planner.posed, planner.rotation)
    together = 0
    for leg in range(LEGS):
        body_to_hip(planner.params, leg, planner.posed, planner.rotation, planner.feet, planner.hip_feet)
        flags = reach_foot(planner.params, leg, planner.hip_feet, planner.reached)
        leg_inverse(planner.params, leg, planner.reached, joints)
        if forces[L_FORCE_Q12 + leg]:
            sag_leg(planner.params, leg, planner.reached, 0, 0, forces[L_FORCE_Q12 + leg], joints)
        flags |= limit_joints(planner.params, leg, joints)
        per_leg[leg] = flags
        together |= flags
    return together
