"""Between command and joints: stands up before walking, sits down before letting go, lets go at once on a stop.

One tick: read the joints, look for faults, take the arbiter's commands, plan, write. Only this module computes the
state and the reason why the robot does not move.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..bus.base import Bus, Measured
from ..robot.gait_names import gait_names
from ..robot.kinematics_si import leg_forward
from ..robot.model import LEG_NAMES, Robot
from ..util.errors import UserError
from .arbiter import Arbiter
from .gait_changes import GaitWatch, crawl_event, exchange_phase
from .joint_stream import JointStream
from .messages import Drive
from .notices import Notices
from .planner import Driver
from .safety import Fault, Safety, how_it_lies, lies_over, torque_limit

# A foot that is further from its rest than this share of the stretched leg is too far away to rise on (chosen).
STRETCHED = 0.5
# How far ahead a falling robot's tilt is extrapolated (chosen: to be limp within 0.1 s).
FALLS_S = 0.1
# Walking to a stop, sitting down and letting go take a few seconds; after this the robot is let go where it is.
LEAVING_S = 20.0
OVER = object()
STATES = ("disarmed", "standing up", "standing", "walking", "crawling", "lifted", "sitting", "fault")
Attitude = tuple[float, float] | None
Rates = tuple[float, float, float] | None
# The planner's state in the driver's words.
_WORDS = {"limp": "disarmed", "folding": "standing up", "rising": "standing up", "seated": "sitting"}
# In these states it does not walk yet, or no longer: what it does instead.
_UP_OR_DOWN = {
    "folding": "it lies on its belly and folds its legs", "rising": "wait until it stands", "sitting": "sitting down",
    "seated": "seated: stand up first",
}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """A change of state: when, to what, and the reason."""

    time_s: float
    state: str
    reason: str


class Supervisor:
    """One robot under one arbiter. ``attitude`` returns roll and pitch in rad, or None while they are unknown.

    ``rates`` returns the turning speeds about x, y, z in rad/s without bias, or None if they are not reliable.
    ``planar``: it moves in the sagittal plane, where it neither sways nor turns, nor folds its legs at its sides.
    ``put_back``: a reset puts a simulated robot that can't get up by itself on its feet; a real one needs a person.
    """

    def __init__(
        self,
        robot: Robot,
        bus: Bus,
        attitude: Callable[[], Attitude] = lambda: None,
        put_back: Callable[[], object] = lambda: None,
        rates: Callable[[], Rates] = lambda: None,
        planar: bool = False,
    ) -> None:
        self.robot, self.bus, self._read_attitude, self._put_back = robot, bus, attitude, put_back
        self._read_rates, self._planar = rates, planar
        self.driver = Driver(robot, planar=planar)
        self.arbiter = Arbiter(gait=robot.gait.default, gaits=gait_names(robot))
        self.safety = Safety(robot)
        self.stream = JointStream(robot, self.driver.rate_hz)
        self.measured = Measured()
        self.attitude: Attitude = None
        self.goals: list[float] = []
        self.armed = self.leaving = False
        self.changes: deque[Change] = deque(maxlen=100)  # the recorder takes them out
        self._limit: float | None = None
        self._stopped = False
        self._resetting: Iterator[None] | None = None
        self._last = ("", "")
        self._gait_watch, self.exchanged = GaitWatch(self.driver), ""
        self._notices = Notices(self.driver.rate_hz)

    def sense(self) -> None:
        """Read the joints and the attitude, and look for faults."""
        self.measured = self.bus.read()
        self.attitude = self._read_attitude()
        if self.armed:
            self.safety.update(self.measured, self._attitude_to_come())
        else:
            self.safety.tell_how_it_lies(self.attitude)

    def _attitude_to_come(self) -> Attitude:
        """Return the attitude; for a robot tilted so far that any gait stops, the one that it will have 0.1 s later.

        A falling robot turns faster than the gyroscope can measure, so the attitude lags behind.
        """
        rates, gets_up = self._read_rates(), self.driver.state in ("folding", "rising")
        if self.attitude is None or rates is None or gets_up:
            return self.attitude
        if max(map(abs, self.attitude)) < self.robot.gait.fallen_rad:
            return self.attitude
        return self.attitude[0] + FALLS_S * rates[0], self.attitude[1] + FALLS_S * rates[1]

    def act(self, now_s: float) -> None:
        """Plan one tick and write its goals, or let go."""
        sticks = self.arbiter.update(now_s)
        self._go_on_resetting()
        self._check_stop()
        self._command(sticks)
        self._feel()
        self.goals = self.stream.goals(self.driver.step(), now_s)
        self._watch_gait()
        self._notices.look(self.driver.flags, self.armed)
        if self.armed and self.driver.state == "limp" and self.driver.command.mode == "limp":
            self.bus.torque(False)
            self.armed, self._limit = False, None
        if self.armed:
            self._limit_torque()
            self.bus.write(self.goals)
        self._note(now_s)

    def _feel(self) -> None:
        """Give the planner the sensed values, except of joints that a program moves: it would react to them."""
        if self.stream.active:
            self.driver.sense(None)
            return
        joints = self.measured.position_rad if self.measured.complete else None
        roll_rad, pitch_rad = self.attitude or (None, None)
        self.driver.sense(joints, roll_rad, pitch_rad, self._read_rates())

    def _watch_gait(self) -> None:
        """Keep why trot and crawl last took over from each other; forget it once the robot stands."""
        self._gait_watch.look()
        if self._gait_watch.notes:
            self.exchanged = self._gait_watch.notes.pop().why
        elif self.driver.state != "walking":
            self.exchanged = ""

    @property
    def remark(self) -> str:
        """What the driver should know beside the state, on pose, readings and gait; or ""."""
        return "; ".join(part for part in (*self._notices.words(), *self._gait_remarks()) if part)

    def _gait_remarks(self) -> tuple[str, ...]:
        """Why the gait changed, what the crawl met."""
        if self.driver.state != "walking":
            return ()
        return self.exchanged, crawl_event(self.driver) if exchange_phase(self.driver) else ""

    def leave(self) -> None:
        """Sit down and let go in the ticks to come; nobody drives any more."""
        self.leaving, self.arbiter.posture, self.arbiter.driver = True, "rest", None

    def stop_now(self) -> None:
        """Let go before anything else; called between two ticks, as soon as a stop comes."""
        self.bus.emergency_stop()
        self.stream.drop()
        self.armed, self._stopped, self._limit, self._resetting = False, True, None, None

    def reset(self) -> None:
        """Forget the faults that are over, in the ticks to come; a reset that is under way goes on."""
        self._stopped = False
        if self._resetting is None:
            self._resetting = self._reset()

    def _go_on_resetting(self) -> None:
        """Do one tick's part of a reset, so that it does not hold up the loop."""
        if self._resetting is not None and next(self._resetting, OVER) is OVER:
            self._resetting = None

    def _reset(self) -> Iterator[None]:
        helpless = self.stretched() or self.safety.action == "limp" if self._planar else lies_over(self.attitude)
        if not self.armed and helpless:
            self._put_back()
            self.attitude = self._read_attitude()
        try:
            while not self.bus.try_clear_faults():
                yield
        except UserError as error:
            self.safety.raise_fault(Fault("limp", "joints", str(error)))
            return
        if self.measured.faults or any(self.measured.error):
            yield  # the joints are read again
        self.safety.reset(self.measured, self.attitude)

    def cannot_rise(self) -> str:
        """Return why the robot can't get up by itself from how it lies, "" if it can.

        It folds its legs first if it knows that it lies on its belly.
        """
        if self.attitude is None or self._planar:
            return self.stretched()
        return how_it_lies(self.attitude) if lies_over(self.attitude) else ""

    def stretched(self) -> str:
        """Return why the robot can't push itself up with the legs where they are, "" if it can.

        A robot that went limp while it walked lies on its belly with the legs stretched to the rear; pushing itself
        up from there tips it over its nose (seen in the plane: by 58 degrees).
        """
        geometry, joints = self.robot.geometry, self.measured.position_rad
        most_m = STRETCHED * geometry.leg_m
        for leg, name in enumerate(LEG_NAMES):
            angles = joints[3 * leg], joints[3 * leg + 1], joints[3 * leg + 2]
            rest_m = self.robot.foot_m(leg, self.robot.stance.sit_height_m)[0]
            off_m = leg_forward(geometry.links_m, self.robot.side(leg), angles)[0] - rest_m
            if abs(off_m) > most_m:
                where = "before" if off_m > 0 else "behind"
                return (
                    f"{name} lies stretched out, its foot {1000 * abs(off_m):.0f} mm {where} the hip, allowed "
                    f"{1000 * most_m:.0f}: put the robot on its feet, seated, then stand up"
                )
        return ""

    def _check_stop(self) -> None:
        limp, damp = self.safety.action == "limp", self.safety.action == "damp"
        if (limp and self.armed) or (self.arbiter.stop is not None and not self._stopped):
            self.stop_now()
        elif damp and self.armed:
            self.stream.drop()
            self.armed, self._limit = False, None
        if (limp or damp) and self._resetting is None:
            self.arbiter.posture = "rest"

    def _command(self, sticks: Drive) -> None:
        """Turn the driver's command into the planner's command."""
        arbiter = self.arbiter
        posture = "rest" if self.safety.action != "none" else arbiter.posture
        if posture != "rest" and not self.armed:
            self._arm()
        self.driver.set_command(
            mode=self._mode(posture, sticks),
            gait=arbiter.gait,
            vx_m_s=sticks.vx_m_s,
            vy_m_s=sticks.vy_m_s,
            wz_rad_s=sticks.wz_rad_s,
            pose=sticks.pose,
            balance=arbiter.balance and self.attitude is not None,
        )

    def _mode(self, posture: str, sticks: Drive) -> str:
        if not self.armed:
            return "limp"
        if posture != "stand":
            self.stream.end()
        if self.stream.active:
            return "stand"
        if posture == "stand":
            folds = self.driver.state == "folding" or (self.driver.state == "limp" and self.stretched() != "")
            return "fold" if folds else "walk" if sticks.moves else "stand"
        return "limp" if posture == "rest" and self.driver.state == "seated" else "sit"

    def _arm(self) -> None:
        """Switch the torque on, limited, with goals where the joints are; a bad line makes this take several ticks."""
        if not self.measured.complete:
            return
        if self.cannot_rise():
            if max(self.measured.age_s) < 1 / self.driver.rate_hz:  # else a lost answer might hide where a leg is now
                self.arbiter.posture = "rest"  # so that it does not rise by itself once somebody has set it upright
            return
        try:
            self._limit = None
            self._limit_torque()
            if not self.bus.try_torque():
                return
        except UserError as error:
            self.safety.raise_fault(Fault("limp", "arming", str(error)))
            return
        self.armed, self._stopped = True, False

    def fastest(self) -> tuple[float, float, float]:
        """Return the gait's top commands: forward and sideways, m/s, and turning, rad/s."""
        return self.driver.fastest(self.arbiter.gait)

    def _limit_torque(self) -> None:
        limit = torque_limit(self.robot, self.driver.state)
        if limit != self._limit:
            self.bus.limit_torque(limit)
            self._limit = limit

    @property
    def state(self) -> str:
        """One of STATES."""
        if self.safety.first is not None:
            return "fault"
        word = self.driver.state
        if self.driver.lifted:
            return "lifted"
        if word == "walking" and exchange_phase(self.driver):
            return "crawling"
        return _WORDS.get(word, word)

    def reason(self, now_s: float) -> str:
        """Why the robot does not move, with what to do; "" while it walks as commanded."""
        arbiter = self.arbiter
        if arbiter.stop is not None:
            return f"emergency stop by {arbiter.stop.client}: reset it, then stand up"
        if self.safety.first is not None:
            return f"{self.safety.sentence}; then reset"
        if not self.measured.complete:
            return "the joints' positions are not known yet"
        if not self.armed:
            return self.cannot_rise() or "the joints are off: stand up first"
        return self._reason_of_state(now_s)

    def _reason_of_state(self, now_s: float) -> str:
        arbiter, planner = self.arbiter, self.driver.state
        if self.leaving:
            return "the program ends: the robot sits down and lets go"
        if self.driver.lifted:
            return self.driver.lifted
        if planner in _UP_OR_DOWN:
            return _UP_OR_DOWN[planner]
        if arbiter.driver is None:
            return "nobody drives: take the controls"
        if not arbiter.fresh(now_s):
            return f"no command from {arbiter.driver} for {arbiter.silent_s(now_s):.1f} s"
        return "" if arbiter.drive.moves else "the sticks are at rest"

    def _note(self, now_s: float) -> None:
        """Keep a change of state or of its reason."""
        arbiter = self.arbiter
        silent = self.armed and arbiter.driver is not None and not arbiter.fresh(now_s)
        reason = f"no command from {arbiter.driver}" if silent else self.reason(now_s)
        if (self.state, reason) != self._last:
            self._last = (self.state, reason)
            self.changes.append(Change(now_s, self.state, reason))
