"""Records each tick of the loop: turns the supervisor's state into the channels' messages."""

import hashlib
import json
from typing import Any

from shared.record import pack

from .. import ROOT
from ..control.gait_changes import gait_now, margin_m
from ..control.loop import Loop
from ..control.supervisor import Supervisor
from ..robot.gait_names import gait_names
from ..robot.model import Robot
from .recorder import Recorder
from .scene import Scene

DRAWN_HZ = 25  # a viewer's picture is smooth (chosen)


def about(robot: Robot, supervisor: Supervisor) -> dict[str, str]:
    """Return the data that a replay needs besides the ticks: the robot as integers, the gaits in order, the core."""
    planner = supervisor.driver.planner
    return {
        "robot": robot.name,
        "rate_hz": str(supervisor.driver.rate_hz),
        "params": " ".join(str(value) for value in pack(planner.params)),
        "gaits": " ".join(gait_names(robot)),
        "own_gaits": json.dumps([own.entry for own in robot.gait.own]),
        "core": core_fingerprint(),
    }


def core_fingerprint() -> str:
    """Return a hash of the core's sources: another core may walk differently."""
    digest = hashlib.sha256()
    root = ROOT / "shared"
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


class LoopLog:
    """Passes every tick of a loop to a recorder."""

    def __init__(self, recorder: Recorder) -> None:
        self._time_ns, self._put = recorder.time_ns, recorder.put
        self._tick = 0
        self._scene: Scene | None = None
        self._fault: Any = None
        self._gait: dict[str, Any] = {}

    def tick(self, loop: Loop) -> None:
        """Record the tick that has just ended."""
        supervisor, now_s = loop.supervisor, loop.clock()
        self._every_tick(loop, supervisor, now_s)
        if self._tick % supervisor.driver.rate_hz == 0:
            measured, errors = supervisor.measured, supervisor.bus.counters.errors
            values = {"temperature_C": measured.temperature_C, "voltage_V": measured.voltage_V, "bus_errors": errors}
            self._put("/health", now_s, values)
        self._draw(supervisor, now_s)
        while supervisor.changes:
            change = supervisor.changes.popleft()
            self._put("/state", change.time_s, {"state": change.state, "reason": change.reason})
        self._note_gait(supervisor, now_s)
        self._note_fault(supervisor, now_s)
        self._tick += 1

    def _every_tick(self, loop: Loop, supervisor: Supervisor, now_s: float) -> None:
        measured, pacer, driver = supervisor.measured, loop.pacer, supervisor.driver
        self._put("/command", now_s, _command(supervisor))
        roll_rad, pitch_rad = supervisor.attitude or (0.0, 0.0)
        known = supervisor.attitude is not None
        self._put("/attitude", now_s, {"known": known, "roll_rad": roll_rad, "pitch_rad": pitch_rad})
        joints = {"wanted_rad": supervisor.goals, "measured_rad": measured.position_rad}
        self._put("/joints", now_s, {**joints, "speed_rad_s": measured.speed_rad_s})
        self._put("/stability", now_s, {"margin_m": margin_m(driver)})
        self._put("/load", now_s, {"load": measured.load})
        late_ms, busy_ms = 1000 * pacer.late_s[-1], 1000 * pacer.busy_s[-1]
        timing = {"late_ms": round(late_ms, 3), "busy_ms": round(busy_ms, 3), "missed": pacer.missed}
        self._put("/timing", now_s, {"tick": self._tick, **timing})
        blocks = {"command": driver.command_integers, "sensed": driver.sensed_integers}
        planned = {"joints": list(driver.planner.joints), "flags": driver.flags}
        self._put("/planner", now_s, {"tick": self._tick, **blocks, **planned})

    def _draw(self, supervisor: Supervisor, now_s: float) -> None:
        """Record the messages for viewers: the robot's parts once a second, their places 25 times."""
        scene = self._scene = self._scene or Scene(supervisor.robot)
        rate_hz, time_ns = supervisor.driver.rate_hz, self._time_ns(now_s)
        measured, drawn = supervisor.measured, dict[str, dict[str, Any]]()
        if self._tick % rate_hz == 0:
            drawn |= scene.parts(time_ns)
        if self._tick % max(1, rate_hz // DRAWN_HZ) == 0:
            at, joints_rad = supervisor.driver.odometry, measured.position_rad
            drawn |= scene.places(time_ns, joints_rad, supervisor.attitude, at, measured.speed_rad_s)
        for topic, values in drawn.items():
            self._put(topic, now_s, values)

    def _note_gait(self, supervisor: Supervisor, now_s: float) -> None:
        walks = gait_now(supervisor.driver) if supervisor.driver.state == "walking" else ""
        gait = {"walks": walks, "remark": supervisor.remark}
        if gait != self._gait:
            self._gait = gait
            self._put("/gait", now_s, gait)

    def _note_fault(self, supervisor: Supervisor, now_s: float) -> None:
        fault = supervisor.safety.first
        if fault is not None and fault is not self._fault:
            self._put("/fault", now_s, {"cause": fault.cause, "action": fault.action, "sentence": fault.sentence})
        self._fault = fault


def _command(supervisor: Supervisor) -> dict[str, Any]:
    arbiter, command = supervisor.arbiter, supervisor.driver.command
    return {
        "driver": "" if arbiter.driver is None else str(arbiter.driver),
        "posture": arbiter.posture,
        "mode": command.mode,
        "gait": command.gait,
        "vx_m_s": command.vx_m_s,
        "vy_m_s": command.vy_m_s,
        "wz_rad_s": command.wz_rad_s,
        "pose": command.pose,
        "balance": command.balance,
        "stop": "" if arbiter.stop is None else str(arbiter.stop.client),
    }
