"""The joints' page: one joint's parameters, its signals as they come, and steps of its goal.

One loop does a cycle of the bus, the pages' requests, and the reading of a parameter, and sends the status to the pages
twenty times a second. The page that arms the joints has to stay open: when it closes, the torque goes off.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from math import degrees, radians
from typing import Any

from shared.wire import names as w

from ..bus.can.joints import CanJoints
from ..bus.can.link import JointView
from ..bus.can.params import find_all, read, write
from ..bus.can.service import joint_name
from ..control.arbiter import Client
from ..control.messages import JOINT_KEYS, Message
from ..protocol.parameters import Parameter, load
from ..robot.coupling import to_joint
from ..robot.model import Robot
from ..util.errors import NOT_ACHIEVED, UserError
from .hub import Hub
from .joint_step import Step

TOLD_EVERY_S = 0.05
VALUES_EVERY_S = 0.25
KEPT_S = 0.5  # of signals in each status, because a page may miss some statuses
BRAD_DEG, WIRE_DEG_S, WIRE_A = 360 / 65536, 360 / 4096, 1 / 4096


def about(robot: Robot, simulated: bool) -> dict[str, Any]:
    """Return a page's first message: the robot, its joints, and the data of each parameter."""
    rows = [[p.name, p.group, p.unit, p.meaning, p.to_value(p.low), p.to_value(p.high), p.access, p.stored]
            for p in load()]  # fmt: skip
    names = [joint_name(node) for node in range(1, 13)]
    return {"robot": robot.name, "simulated": simulated, "joints": names, "parameters": rows}


class JointPage:
    """The pages' view and actions. It makes ``hub``; ``clock`` paces joints in simulated time."""

    def __init__(self, bus: CanJoints, clock: Callable[[], float] = time.monotonic) -> None:
        self._bus, self._clock = bus, clock
        self.hub = Hub(self._receive, self._drop, keys=JOINT_KEYS)
        self._does: dict[str, Callable[[Client, Message], object]] = {
            "joint": lambda _, said: self._choose(said["node"]), "parameter": self._write, "keep": self._keep,
            "arm": self._arm, "step": self._begin_step, "clear": lambda *_: bus.clear_faults(), "stop": self._stop,
        }  # fmt: skip
        self._node, self._values = 1, dict[str, float]()
        self._reading: Iterator[Parameter] = iter(())
        self._samples: deque[list[float | None]] = deque(maxlen=round(KEPT_S / bus.cycle.period_s))
        self._step: Step | None = None
        self._armer: Client | None = None
        self._told = ""
        self._tell_s = self._values_s = 0.0
        self._ahead_s = bus.now() - clock()  # simulated time less this clock's
        self._choose(1)

    def tick(self) -> None:
        """Do one cycle, and the work that is due after it."""
        bus = self._bus
        bus.run_for(bus.cycle.period_s)
        self._sample()
        if self._armer is not None and not bus.cycle.armed:
            self._give_up("; ".join(notice.sentence for notice in bus.cycle.notices) or "the joints let go")
        self._go_on_stepping()
        self.hub.poll(max(0.0, bus.now() - self._clock() - self._ahead_s))
        self._read_one()
        if bus.now() >= self._tell_s:
            self._tell_s = bus.now() + TOLD_EVERY_S
            self.hub.tell(self._status())
        if bus.now() >= self._values_s:
            self._values_s = bus.now() + VALUES_EVERY_S
            self.hub.tell({"type": "values", "node": self._node, "values": self._values})

    def close(self) -> None:
        """Take the torque away and hang up."""
        if self._armer is not None:
            self._bus.torque(False)
        self.hub.close()

    # the pages' requests

    def _receive(self, client: Client, message: Message) -> bool:
        try:
            self._does[message["type"]](client, message)
        except UserError as error:
            self._told = str(error)
        return True

    def _drop(self, client: Client) -> None:
        if client == self._armer:
            self._bus.torque(False)
            self._give_up("the page that armed the joints is gone: they are off")

    def _choose(self, node: int) -> None:
        self._node, self._values, self._reading = node, {}, iter(find_all(None))
        self._samples.clear()

    def _write(self, client: Client, said: Message) -> None:
        parameter = find_all([said["name"]])[0]
        self._told = ""
        raw = write(self._bus.requests, said["node"], parameter, said["value"])
        if said["node"] == self._node:
            self._values[parameter.name] = parameter.to_value(raw)
        value = f"{parameter.to_value(raw):.6g} {parameter.unit}".strip()
        self._told = f"{joint_name(said['node'])}: {parameter.name} is {value} until it loses power; Keep saves it"

    def _keep(self, client: Client, said: Message) -> None:
        self._bus.requests.demand(said["node"], w.COMMAND_SAVE_PARAMETERS)
        self._told = f"{joint_name(said['node'])}: its parameters are saved"

    def _arm(self, client: Client, said: Message) -> None:
        if not said["on"]:
            self._bus.torque(False)
            self._give_up("the joints are off")
        elif self._armer is None:
            self._bus.make_ready()
            self._bus.limit_torque(self._bus.robot.stand.torque_fraction)
            self._bus.torque(True)
            self._armer, self._told = client, "all joints hold their present angles"

    def _stop(self, client: Client, said: Message) -> None:
        self._bus.emergency_stop()
        self._give_up("emergency stop: all joints are off")

    def _give_up(self, why: str) -> None:
        self._armer, self._step, self._told = None, None, why

    # a step

    def _begin_step(self, client: Client, said: Message) -> None:
        goals = self._bus.cycle.goals_brad
        if self._armer is None or goals is None:
            raise UserError("a step: arm the joints first", NOT_ACHIEVED)
        if self._step is not None:
            raise UserError("a step is running: wait for its end", NOT_ACHIEVED)
        node, deg = said["node"], said["deg"]
        there = [goal * BRAD_DEG for goal in goals]
        away = [angle + (deg if at == node - 1 else 0.0) for at, angle in enumerate(there)]
        self._check_reach(node, away)
        self._step = Step(node, there[node - 1], deg, self._bus.now(), said["seconds"])
        self._set_goals(away)
        self._told = f"{joint_name(node)}: a step of {deg:g} deg for {said['seconds']:g} s"

    def _check_reach(self, node: int, motors_deg: list[float]) -> None:
        """Refuse motor angles that take a joint of the leg beyond its limits; a calf's depends on its thigh's."""
        robot, leg = self._bus.robot, (node - 1) // 3
        joints = to_joint(robot, [radians(angle) for angle in motors_deg])
        for at, (low, high) in enumerate(robot.joint_limits_rad(leg), 3 * leg):
            if not low <= joints[at] <= high:
                limits = f"{degrees(low):.1f} .. {degrees(high):.1f} deg"
                raise UserError(f"{joint_name(at + 1)} would go to {degrees(joints[at]):.1f} deg: allowed {limits}")

    def _go_on_stepping(self) -> None:
        step = self._step
        if step is None or not step.take(self._bus.now(), self._position_deg(step.node)):
            return
        if step.over:
            self._step, self._told = None, f"{joint_name(step.node)}: {step.told()}"
        else:
            goals = [goal * BRAD_DEG for goal in self._bus.cycle.goals_brad or ()]
            goals[step.node - 1] = step.from_deg
            self._set_goals(goals)

    def _set_goals(self, motors_deg: list[float]) -> None:
        self._bus.cycle.set_goals([radians(angle) for angle in motors_deg])

    # the pages' status

    def _read_one(self) -> None:
        """Read the next parameter of the chosen joint, but none during a step, which needs the bus."""
        parameter = None if self._step else next(self._reading, None)
        if parameter is None:
            return
        try:
            self._values[parameter.name] = parameter.to_value(read(self._bus.requests, self._node, parameter))
        except UserError as error:
            self._told, self._reading = str(error), iter(())

    def _position_deg(self, node: int) -> float | None:
        raw = self._bus.link.views[node].reply.position
        return None if raw == w.NOT_AVAILABLE else raw * BRAD_DEG

    def _sample(self) -> None:
        """Keep the chosen joint's signals: time, goal, angle, speed, current, winding, supply."""
        bus, view = self._bus, self._bus.link.views[self._node]
        goals, reply, slow = bus.cycle.goals_brad, view.reply, view.status
        goal = goals[self._node - 1] * BRAD_DEG if goals else None
        speed = None if reply.velocity == w.NOT_AVAILABLE else reply.velocity * WIRE_DEG_S
        current = None if reply.current == w.NOT_AVAILABLE else reply.current * WIRE_A
        heat = None if slow.winding_temperature == w.NOT_AVAILABLE_13 else slow.winding_temperature / 16
        told = [bus.now(), goal, self._position_deg(self._node), speed, current, heat, slow.bus_voltage / 16]
        self._samples.append([None if value is None else round(value, 4) for value in told])

    def _status(self) -> dict[str, Any]:
        views = [self._bus.link.views[node] for node in self._bus.link.nodes]
        return {
            "type": "status",
            "node": self._node,
            "armed": self._armer is not None,
            "stepping": self._step is not None,
            "told": self._told,
            "joints": [self._state(view) for view in views],
            "samples": list(self._samples),
        }

    def _state(self, view: JointView) -> str:
        """Return a joint's state in words, with its fault if it has one."""
        if view.node not in self._bus.link.alive():
            return "not there"
        if view.heartbeat.fault:
            return self._bus.cycle.guard.fault_text(view)
        return view.state_words
