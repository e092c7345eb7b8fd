"""The figures of the joints' bus: codec against cantools, load, time of a cycle, speed against direct control."""

import random
import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import tau
from statistics import median

from shared.wire import names as w

from ...bus.can.host_loops import SETPOINTS, HostLoops
from ...bus.can.link import JointLink
from ...bus.can.load import busload, default_schedule
from ...bus.can.port import Port, Received
from ...protocol import dbc, frames
from ...protocol.generate_docs import expanded_dbc
from ...robot.coupling import to_motor
from ...robot.joint_gains import joint_blocks
from ...robot.joint_setups import joint_setups
from ...robot.model import Robot
from ...sim.joints.sim_walk import SimWalk

FROM_M = 0.1  # by then the robot walks steadily
CYCLES = 300
LATE_MS = 20  # direct control's goals come a planner's tick late, as over the bus
STEP_MS = 5


@dataclass(frozen=True)
class Figure:
    """One line: what, the bar in words, the value found, and whether it reaches the bar."""

    what: str
    wanted: str
    found: str
    reached: bool


def codec_figure(count: int) -> Figure:
    """Compare random frames of each message with cantools, both ways."""
    import cantools

    database = cantools.database.load_string(expanded_dbc(dbc.load()), "dbc")
    messages = [message for message in dbc.load() if message.signals]
    different = sum(_differs(database, message, random.Random(message.first), count) for message in messages)
    found = f"{different} of {count * len(messages)} differ ({count} of each of {len(messages)} types)"
    return Figure("codec against cantools, both ways", "0 differ", found, different == 0)


def _differs(database: object, message: dbc.Message, draw: random.Random, count: int) -> int:
    different = 0
    for _ in range(count):
        identifier = draw.choice(message.identifiers)
        theirs = database.get_message_by_frame_id(identifier)  # type: ignore[attr-defined]
        raws = [draw.randint(s.low, s.high) for s in message.signals]
        names = [signal.name for signal in sorted(theirs.signals, key=lambda signal: signal.start)]
        by_name = dict(zip(names, raws, strict=True))
        data = theirs.encode(by_name, scaling=False, strict=False)
        same = frames.encode(identifier, raws) == (data, 0)
        read = theirs.decode(data, scaling=False, decode_choices=False)
        different += not (same and frames.decode(identifier, data) == ([read[name] for name in names], 0))
    return different


def load_figures(robot: Robot) -> list[Figure]:
    """Print the worst case, and compare the typical with the frames really sent in two seconds of walking."""
    assert robot.bus.kind == "can"
    total = busload(default_schedule(robot.bus.rate_hz), robot.bus.bitrate)[-1]
    with SimWalk(robot) as walk:
        walk.arm()
        walk.stand_up()
        bus = walk.sim.bus
        bits, start_us = bus.bits, bus.now_us
        walk.go(2.0)
        share = (bus.bits - bits) / (bus.bitrate * 1e-6 * (bus.now_us - start_us))
    worst, off = 100 * total.worst_share, 100 * abs(share / total.typical_share - 1)
    what = f"bus load at {robot.bus.rate_hz} Hz, 12 joints"
    return [
        Figure(f"{what}, worst case", "at most 40 %", f"{worst:.1f} %", worst <= 40),
        Figure(
            f"{what}, frames actually sent", "within 1 % of typical", f"{100 * share:.2f} %, {off:.2f} % off", off <= 1
        ),
    ]


class Replies(Port):
    """A port on which every joint has replied."""

    def __init__(self) -> None:
        super().__init__()
        self._frames = [sample for item in default_schedule() if item.name == "reply" for sample in item.samples[::50]]
        self._left: list[tuple[int, bytes]] = []

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port."""
        if identifier == w.SYNC_ID:
            self._left = list(self._frames)
        return True

    def receive(self) -> Received | None:
        """See Port."""
        return Received(0.0, *self._left.pop()) if self._left else None

    def now(self) -> float:
        """See Port."""
        return 0.0

    def wait_until(self, time_s: float) -> None:
        """See Port."""


def cycle_s(robot: Robot, kind: str) -> float:
    """Return the median time of decode, twelve loops, encode and SYNC on this machine."""
    assert robot.bus.kind == "can"
    assert robot.actuator.kind == "bldc"
    link = JointLink(Replies(), 17)
    blocks = [joint_blocks(robot.actuator, setup) for setup in joint_setups(robot)]
    loops = HostLoops(blocks, robot.actuator.drive, robot.bus.rate_hz, kind)
    times = []
    for _ in range(CYCLES):
        began = time.perf_counter()
        link.receive()
        link.send_setpoints(loops.identifier, loops.setpoints([100] * 12, [1.0] * 12, link.views))
        link.sync()
        times.append(time.perf_counter() - began)
    assert link.views[12].replies > CYCLES - 10
    return median(times)


def cycle_figures(robot: Robot) -> list[Figure]:
    """Return what a cycle with loops on the host costs: decode, cascade, encode."""
    rows = []
    for kind in SETPOINTS:
        took_ms = 1000 * cycle_s(robot, kind)
        what = f"host cycle for 12 joints, {kind}"
        rows.append(Figure(what, "at most 1.0 ms median", f"{took_ms:.2f} ms", took_ms <= 1.0))
    return rows


class Direct(SimWalk):
    """The same joints with the planner's goals put straight into them, a tick late, without any bus."""

    def arm(self) -> None:
        """See SimWalk."""
        super().arm()
        self._late = list(self.sim.body.angle_rad)

    def _tick(self) -> None:
        pitch, rate = self.sim.body.pitch(self.sim.time_s)
        self.driver.sense(self.sim.body.position_rad, 0.0, pitch, (0.0, rate, 0.0))
        goals = to_motor(self.robot, self.driver.step())
        for _ in range(LATE_MS // STEP_MS):
            self.sim.advance_ms(STEP_MS)
            self._put(self._late)
        self._late = goals

    def _put(self, goals_rad: Sequence[float]) -> None:
        for joint, goal in zip(self.sim.joints, goals_rad, strict=True):
            io = joint.inside.joint.control.io  # type: ignore[union-attr]
            io.position = round(goal * 65536 / tau)
            io.sequence += 1


def speed_m_s(walk: SimWalk, distance_m: float) -> float:
    """Return the speed from ``FROM_M`` on over a distance, after arming and standing up."""
    with walk:
        walk.arm()
        walk.stand_up()
        body, rows = walk.sim.body, []
        start_m, end_s = body.x_m, walk.sim.time_s + 40 * distance_m + 5
        while body.x_m - start_m < distance_m and walk.sim.time_s < end_s:
            walk.go(0.02)
            if body.x_m - start_m >= FROM_M:
                rows.append((walk.sim.time_s, body.x_m))
    return (rows[-1][1] - rows[0][1]) / (rows[-1][0] - rows[0][0]) if len(rows) > 1 else 0.0


def speed_figure(robot: Robot, distance_m: float) -> Figure:
    """Walk at 0.05 m/s over CAN and with direct control."""
    over_can, direct = speed_m_s(SimWalk(robot), distance_m), speed_m_s(Direct(robot), distance_m)
    off = 100 * abs(over_can / direct - 1)
    found = f"{1000 * over_can:.1f} beside {1000 * direct:.1f} mm/s, {off:.1f} % off"
    return Figure(f"speed over CAN against direct control, {distance_m:g} m", "within 5 %", found, off <= 5)
