"""`Robot`: walks, poses and joints of a robot in a few lines, in simulation as on hardware (docs/python.md)."""

from collections.abc import Iterator, Mapping, Sequence
from math import copysign, cos, hypot, inf, isfinite, radians, sin, sqrt
from pathlib import Path
from types import TracebackType
from typing import Self

from ..control.health import Finding
from ..control.messages import Drive
from ..control.odometry import Odometry
from ..robot.file import load_robot
from ..robot.gait_advice import gait_advice
from ..robot.gait_file import with_gait
from .errors import BadValue, Error, Fault, NotAchieved, finite, number, own_words, shown
from .places import Place, find_place
from .run import Run
from .sensed import JOINT_NAMES, Sensed

# Generous: a crawl sets down four feet before it stands. After this time the caller gets an error (chosen).
STAND_MOST_S, STOP_MOST_S, RESET_MOST_S, ALIGN_MOST_S = 20.0, 30.0, 2.0, 5.0
SLOWEST_TURN = 0.15  # of the top turning speed: the speed near the angle (chosen)
TURNED_RAD = radians(1.0)  # within this of the angle the turn is done (chosen)
SLOWEST_HZ = 5.0  # a slower stream would trigger its own dead-man
LONGEST_S = 3600.0

Goals = Sequence[float] | Mapping[str, float]


class Robot:
    """One robot in one place. Nothing moves before ``stand``; the end of a ``with`` block sits it down.

    Args:
        place: ``sim`` (the sagittal plane), ``space`` (three dimensions, extra `space`), ``servos`` or ``can``; or a
            Place of one's own (host/library/places.py), for which port, calibration and imu are not asked.
        robot: a robot's name, or the path of a robot file ending in .toml.
        gait: a gait's name, or the path of a gait file (docs/gaits.md); default: the robot file's own.
        port: for servos the serial port, for CAN ``INTERFACE:CHANNEL``; default: the robot file's own.
        calibration: the servos' calibration file; default: the robot's own.
        imu: ``i2c``, a gait board's port or a recording; ``""`` is the usual one, None is none.
        record: an MCAP file to write, or a folder for one; needs the extra `record`.
        honest: for ``sim`` and ``space``: drives with friction, play, a sagging supply; None: as the file says.

    In ``sim`` and ``space`` time passes only in calls that wait, as fast as it is computed, and the same calls give the
    same motion. With servos and CAN the control loop runs in a thread of its own.

    Every error is a caramelo.Error: BadValue for a wrong argument (nothing has moved), NotAchieved, Fault for a robot
    that stopped by itself or was stopped.
    """

    def __init__(
        self,
        place: str | Place = "sim",
        robot: str | Path = "caramelo",
        *,
        gait: str | Path | None = None,
        port: str | Path | None = None,
        calibration: str | Path | None = None,
        imu: str | Path | None = "",
        record: str | Path | None = None,
        honest: bool | None = None,
    ) -> None:
        if honest not in (None, True, False):
            raise BadValue(f"honest {shown(honest)}: allowed True, False or None")
        hardware = _text("port", port), _path("calibration", calibration), _text("imu", imu)
        self._record = _path("record", record)
        with own_words():
            self._file = load_robot(str(robot)).simulated(honest)
            if str(gait).endswith(".toml"):
                self._file, gait = with_gait(self._file, str(gait)), None
            self._place = place if isinstance(place, Place) else find_place(place, self._file, *hardware, honest)
        self._gait = self._known_gait(self._file.gait.default if gait is None else gait)
        self._run: Run | None = None
        self._pose: tuple[float, float, float, float, float, float] = (0.0,) * 6
        self._joint_rad_s: float | None = None  # in a loop over stream: the top speed of its joints

    # --- from opening to closing

    def open(self) -> Self:
        """Connect to the joints and check them without moving any; Error if a check fails. `with` calls it."""
        if self._run is not None:
            raise Error("the robot is already open")
        with own_words():
            self._run = Run(self._file, self._place, self._record)
        self._run.send({"type": "gait", "gait": self._gait})
        self._run.ticks.wait()
        return self

    def close(self) -> None:
        """Sit down, let the joints go, end the record; if it can't sit, let go at once. May be called twice.

        Error if a part of the record is missing, as on a full disk: the robot went on without it.
        """
        run, self._run = self._run, None
        if run is not None:
            run.close()

    def __enter__(self) -> Self:
        return self if self._run is not None else self.open()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        try:
            self.close()
        except Error:
            if error is None:
                raise  # else the block's own error is the first cause

    @property
    def _opened(self) -> Run:
        if self._run is None:
            raise Error("the robot is not open: write `with Robot(...) as robot:`, or call open()")
        return self._run

    # --- data

    @property
    def name(self) -> str:
        """The robot file's name."""
        return self._file.name

    @property
    def sensed(self) -> Sensed:
        """The values after the last tick: joints, attitude, state, battery."""
        return self._opened.sensed

    @property
    def odometry(self) -> Odometry:
        """Where the robot has walked to since it was opened, by dead reckoning with its legs and the gyro.

        It assumes that loaded feet stay in place: a slip stays in it as an error, whose size its covariance estimates.
        In ``sim``, the plane, nothing can turn; there it turns as the legs command. ``truth`` is the real motion of a
        simulated body.
        """
        return self._opened.sensed.odometry

    @property
    def truth(self) -> tuple[float, float, float]:
        """Where a simulated body is: x and y in m, yaw in rad. Error on hardware, where it is unknown."""
        if self._place.truth is None:
            raise Error("truth: only a simulator knows where the robot is; use odometry")
        return self._place.truth()

    @property
    def joint_limits_rad(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest angle of the twelve joints, in the order of JOINT_NAMES."""
        return tuple(limit for leg in range(4) for limit in self._file.joint_limits_rad(leg))

    @property
    def gaits(self) -> dict[str, str]:
        """Every gait's name with why it is not advised for this robot, "" if it is."""
        return gait_advice(self._file)

    @property
    def gait(self) -> str:
        """The gait of the walks to come; set it to another's name."""
        return self._gait

    @gait.setter
    def gait(self, name: str) -> None:
        self._gait = self._known_gait(name)
        if self._run is not None:
            self._run.send({"type": "gait", "gait": self._gait})

    def _known_gait(self, name: object) -> str:
        if not isinstance(name, str) or name not in self.gaits:
            raise BadValue(f"gait {shown(name)}: allowed {', '.join(self.gaits)}")
        return name

    def health(self, seconds: float = 2.0) -> tuple[Finding, ...]:
        """Let time pass, then return how the robot is: a line for each part with the verdict ok, note or bad.

        The parts: robot, loop, missed deadlines, bus errors by joint, IMU, battery, heat, versions. Counts begin
        when the robot was opened. This moves nothing, and a fault is one of its lines, not an error.
        """
        run = self._opened
        for _ in range(round(finite("seconds", seconds, 0.0, LONGEST_S, "s") * run.rate_hz)):
            run.ticks.wait()
        return run.findings()

    # --- postures

    def stand(self) -> None:
        """Stand up and return once the robot stands; first it holds still until the gyro's bias is known."""
        run = self._opened
        attitude = self._place.hardware.attitude
        run.until(lambda now: attitude.state != "aligning" or now.state != "disarmed", ALIGN_MOST_S, "attitude")
        run.send({"type": "posture", "posture": "stand"})
        run.until(self._stands, STAND_MOST_S, "stand")

    def sit(self) -> None:
        """Sit down, let the joints go, and return once they are."""
        run = self._opened
        run.sticks = None
        run.send({"type": "posture", "posture": "rest"})
        run.until(lambda now: now.state == "disarmed", STAND_MOST_S, "sit")

    def pose(
        self,
        x_m: float = 0.0,
        y_m: float = 0.0,
        z_m: float = 0.0,
        roll_deg: float = 0.0,
        pitch_deg: float = 0.0,
        yaw_deg: float = 0.0,
    ) -> None:
        """Hold the body shifted and turned from its stance, also in the walks to come, and return once it is there.

        The robot must stand. Ranges are the robot file's [body_limits]; if the legs do not reach a pose, the robot
        holds the nearest one, and ``sensed.remark`` says so.
        """
        limits = self._file.body_limits
        shift_m = [finite(n, v, -m, m, "m") for n, v, m in
                   (("x_m", x_m, limits.x_m), ("y_m", y_m, limits.y_m), ("z_m", z_m, limits.z_m))]  # fmt: skip
        angles = (("roll_deg", roll_deg, limits.roll_deg), ("pitch_deg", pitch_deg, limits.pitch_deg),
                  ("yaw_deg", yaw_deg, limits.yaw_deg))  # fmt: skip
        turn = [radians(finite(name, value, -most, most, "deg")) for name, value, most in angles]
        run = self._standing()
        before, self._pose = self._pose, (shift_m[0], shift_m[1], shift_m[2], turn[0], turn[1], turn[2])
        way = [abs(now - then) for now, then in zip(self._pose, before, strict=True)]
        seconds = max(max(way[:3]) / limits.shift_m_s, max(way[3:]) / limits.turn_rad_s)
        with run.driving(Drive(pose=self._pose)):
            for _ in range(round(seconds * run.rate_hz) + 1):
                run.tick()

    def stop(self) -> None:
        """Emergency stop: let the joints go at once, from any thread. It stays so until ``reset``.

        A software stop is not a power cut: keep a switch within reach.
        """
        self._opened.emergency_stop()

    def reset(self) -> None:
        """Forget a stop or a fault that is over; Fault if it is not. This puts a fallen simulated robot on its feet.

        Without a stop or a fault it does nothing.
        """
        run = self._opened
        if not run.sensed.fault:
            return
        run.send({"type": "reset"})
        for _ in range(round(RESET_MOST_S * run.rate_hz)):
            try:
                run.tick()
                return
            except Fault as fault:
                last = fault
        raise last

    # --- walking

    def walk(
        self,
        vx_m_s: float = 0.0,
        vy_m_s: float = 0.0,
        wz_rad_s: float = 0.0,
        *,
        seconds: float | None = None,
        distance_m: float | None = None,
    ) -> None:
        """Walk forward, to the left and turning (left is positive), then stop; return once the robot stands.

        Give either a time, or a distance by ``odometry``. BadValue for speeds above those of robot and gait;
        NotAchieved if the distance takes five times as long as it should, and 20 s.
        """
        sticks = self._sticks(vx_m_s, vy_m_s, wz_rad_s)
        if (seconds is None) == (distance_m is None):
            raise BadValue("walk: give either seconds or distance_m")
        if seconds is not None:
            self._walk_for(sticks, finite("seconds", seconds, 0.0, LONGEST_S, "s"))
            return
        distance_m = finite("distance_m", distance_m, 0.0, 1000.0, "m")
        speed_m_s = hypot(sticks.vx_m_s, sticks.vy_m_s)
        if sticks.wz_rad_s or not speed_m_s:
            raise BadValue("distance_m: only straight ahead or sideways, with a speed; for a curve give seconds")
        self._walk_way(sticks, distance_m, 20.0 + 5.0 * distance_m / speed_m_s)

    def turn(self, deg: float, wz_rad_s: float | None = None) -> None:
        """Turn on the spot by an angle, to the left if it is positive, by ``odometry``; return once the robot stands.

        ``wz_rad_s``: the top turning speed; default: that of robot and gait.
        """
        angle_rad = radians(finite("deg", deg, -3600.0, 3600.0, "deg"))
        most = self._fastest()[2]
        most = most if wz_rad_s is None else finite("wz_rad_s", wz_rad_s, 0.01, most, "rad/s")
        run, slew_rad_s2 = self._standing(), self._opened.supervisor.driver.robot.speed_limits.wz_rad_s2
        start_rad, most_s = run.sensed.odometry.yaw_rad, 20.0 + 5.0 * abs(angle_rad) / most

        def there(now: Sensed) -> bool:
            left_rad = angle_rad - (now.odometry.yaw_rad - start_rad)
            stops_rad_s = sqrt(slew_rad_s2 * abs(left_rad))  # it can stop within half of the remaining angle
            wz_rad_s = min(most, max(SLOWEST_TURN * most, stops_rad_s))
            run.sticks = Drive(wz_rad_s=copysign(wz_rad_s, left_rad), pose=self._pose)
            return abs(left_rad) < TURNED_RAD

        with run.driving(None):
            run.until(there, most_s, f"turn by {deg:g} deg")
        self._halt()

    def _sticks(self, vx_m_s: float, vy_m_s: float, wz_rad_s: float) -> Drive:
        most = self._fastest()
        return Drive(
            finite("vx_m_s", vx_m_s, -most[0], most[0], f"m/s by {self.gait}"),
            finite("vy_m_s", vy_m_s, -most[1], most[1], f"m/s by {self.gait}"),
            finite("wz_rad_s", wz_rad_s, -most[2], most[2], f"rad/s by {self.gait}"),
            self._pose,
        )

    def _fastest(self) -> tuple[float, float, float]:
        return self._opened.supervisor.driver.fastest(self.gait)

    def _walk_for(self, sticks: Drive, seconds: float) -> None:
        run = self._standing()
        with run.driving(sticks):
            for _ in range(round(seconds * run.rate_hz)):
                run.tick()
        self._halt()

    def _walk_way(self, sticks: Drive, distance_m: float, most_s: float) -> None:
        run = self._standing()
        start, speed = run.sensed.odometry, hypot(sticks.vx_m_s, sticks.vy_m_s)
        ahead, left = sticks.vx_m_s / speed, sticks.vy_m_s / speed
        c, s = cos(start.yaw_rad), sin(start.yaw_rad)
        east, north = c * ahead - s * left, s * ahead + c * left  # the direction in the odometry's axes

        def gone_m() -> float:
            now = run.sensed.odometry
            return (now.x_m - start.x_m) * east + (now.y_m - start.y_m) * north

        try:
            with run.driving(sticks):
                run.until(lambda now: gone_m() >= distance_m, most_s, f"walk {distance_m:g} m")
        except NotAchieved as error:
            raise NotAchieved(f"{error}; the robot walked {gone_m():.3f} m") from None
        self._halt()

    def _halt(self) -> None:
        """Stop walking and return once the robot stands."""
        with self._opened.driving(Drive(pose=self._pose)):
            self._opened.until(self._stands, STOP_MOST_S, "stop")

    def _standing(self) -> Run:
        """Return the run of a robot that stands, or that will stand after a stream."""
        run = self._opened
        if run.sensed.fault:
            raise Fault(run.sensed.fault)
        if run.supervisor.stream.open:
            raise Error("set_joints moves the joints: leave its loop first")
        if run.sensed.state in ("disarmed", "sitting"):
            raise Error(f"the robot does not stand, it is {run.sensed.state}: call stand() first")
        self._halt()
        return run

    def _stands(self, now: Sensed) -> bool:
        return now.state == "standing" and not self._opened.supervisor.stream.active

    # --- a loop of one's own

    def stream(
        self, hz: float = 50.0, *, seconds: float | None = None, joint_rad_s: float | None = None
    ) -> Iterator[Sensed]:
        """Yield the sensed values ``hz`` times a second; the loop drives with ``set_speed`` or ``set_joints``.

        ``hz`` 5 .. the planner's rate, rounded so that its period is whole ticks. It ends after ``seconds``, or when
        the loop is left. ``joint_rad_s``: the top speed of a joint with ``set_joints``; default: the speed at which the
        robot stands up ([stand] of its file).

        Every tick checks that no joint goes beyond its limits or turns faster. If nothing is set for 0.3 s, the robot
        stops walking and the joints go back to the stance; so they do at the end.
        """
        run = self._opened
        joints = run.supervisor.stream
        hz = finite("hz", hz, SLOWEST_HZ, run.rate_hz, "Hz")
        fastest = joints.fastest_rad_s
        asked = joints.usual_rad_s if joint_rad_s is None else finite("joint_rad_s", joint_rad_s, 0.0, fastest, "rad/s")
        until_s = inf if seconds is None else finite("seconds", seconds, 0.0, LONGEST_S, "s")
        return self._stream(run, round(run.rate_hz / hz), asked, until_s * hz - 0.5)

    def _stream(self, run: Run, every: int, joint_rad_s: float, most: float) -> Iterator[Sensed]:
        self._standing()
        self._joint_rad_s = joint_rad_s
        count = 0
        try:
            while count < most:
                count += 1
                for _ in range(every):
                    run.tick()
                run.sticks = None
                yield run.sensed
        finally:
            self._joint_rad_s = run.sticks = None
            if self._run is run:
                run.ticks.do(run.supervisor.stream.end)

    def set_speed(self, vx_m_s: float = 0.0, vy_m_s: float = 0.0, wz_rad_s: float = 0.0) -> None:
        """Walk at these speeds until the next turn of a loop over ``stream``; the ranges are those of ``walk``."""
        self._streaming("set_speed")
        if self._opened.supervisor.stream.active:
            raise Error("set_speed: set_joints moves the joints; leave its loop first")
        self._opened.sticks = self._sticks(vx_m_s, vy_m_s, wz_rad_s)

    def set_joints(self, goals_rad: Goals) -> tuple[str, ...]:
        """Set joint goals, rad, in a loop over ``stream``; return the names of the joints that were limited.

        Twelve angles in the order of JOINT_NAMES, or a mapping of some of those names: the others keep their goals.
        BadValue, and nothing changes, for anything but finite numbers. The robot stands while its joints are set.
        """
        run, joint_rad_s = self._opened, self._streaming("set_joints")
        joints = run.supervisor.stream
        if not joints.open and run.sensed.state != "standing":
            raise Error(f"set_joints: the robot does not stand, it is {run.sensed.state}")
        goals = _angles(goals_rad, joints.wished or run.sensed.goals_rad)
        limited: list[int] = []

        def wish() -> None:
            if not joints.open:
                joints.begin(run.supervisor.goals, joint_rad_s, run.loop.clock())
            limited.extend(joints.wish(goals, run.loop.clock()))

        run.ticks.do(wish)
        return tuple(JOINT_NAMES[joint] for joint in limited)

    def _streaming(self, what: str) -> float:
        if self._joint_rad_s is None:
            raise Error(f"{what}: only within a loop `for sensed in robot.stream():`")
        return self._joint_rad_s


def _path(name: str, value: object) -> Path | None:
    text = _text(name, value)
    return None if text is None else Path(text)


def _text(name: str, value: object) -> str | None:
    if value is None:
        return None
    if isinstance(value, str | Path) and "\0" not in str(value):
        return str(value)
    raise BadValue(f"{name} {shown(value)}: allowed a path as text or Path, or None")


def _angles(goals_rad: object, before_rad: Sequence[float]) -> list[float]:
    """Return twelve finite angles, or raise BadValue."""
    if isinstance(goals_rad, Mapping):
        for name in goals_rad:
            if name not in JOINT_NAMES:
                raise BadValue(f"set_joints: joint {name!r}: allowed {', '.join(JOINT_NAMES)}")
        goals_rad = [goals_rad.get(name, before) for name, before in zip(JOINT_NAMES, before_rad, strict=True)]
    try:
        goals = list(goals_rad)  # type: ignore[call-overload]
    except TypeError:
        raise BadValue(f"set_joints: {type(goals_rad).__name__}: allowed 12 angles, or angles by joint name") from None
    if len(goals) != len(JOINT_NAMES):
        raise BadValue(f"set_joints: {len(goals)} values: allowed 12")
    return [_angle(name, goal) for name, goal in zip(JOINT_NAMES, goals, strict=True)]


def _angle(name: str, goal: object) -> float:
    angle = number(goal)
    if isfinite(angle):
        return angle
    raise BadValue(f"set_joints: {name} {shown(goal)}: allowed a finite angle in rad")
