"""Finds what is wrong with the joints as a whole, and says what the whole robot does about it.

``refuse``: do not arm. ``damp``: quick stop of all joints, set-points end, each joint damps, then coasts.
``sit``: the planner should sit the robot down while it still can. ``stop``: an emergency stop, torque off at once. The
strongest reaction of all notices counts.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

from shared.joint.faults import FAULT_DUPLICATE_ID
from shared.wire import names as w

from ...robot.joint_faults import fault_name, fault_sentence
from ...robot.joint_units import Units
from .link import HEARTBEAT_S, JointLink, JointView
from .service import joint_name

REACTIONS = ("none", "refuse", "sit", "damp", "stop")  # rising
E_STOP = "an emergency stop came over the bus: find out who sent it, clear the faults, then arm"
NOBODY = "check the supply, the CAN cable and both terminators, and that this is the right interface and channel"
SILENT_S = 0.05  # ten cycles at 200 Hz without a reply while armed
LOSS_SHARE = 0.1  # of the replies of a window
LOSS_WINDOW = 200  # cycles

_HOT = w.LIMIT_WINDING_TEMPERATURE | w.LIMIT_MCU_TEMPERATURE


@dataclass(frozen=True)
class Notice:
    """Something wrong: with which node (0: all), what, in a sentence with what to do, and the reaction."""

    node: int
    what: str
    sentence: str
    reaction: str


def worst(notices: Iterable[Notice]) -> str:
    """Return the strongest reaction of all notices."""
    return max((notice.reaction for notice in notices), key=REACTIONS.index, default="none")


class Guard:
    """Watches a link; ``units`` turns fault values into SI."""

    def __init__(self, link: JointLink, units: Units | None = None) -> None:
        self.link, self._units = link, units
        self._replies = dict.fromkeys(link.nodes, 0)
        self._window_start = 0
        self._lossy: set[int] = set()

    def start(self) -> None:
        """Count lost replies from here on."""
        self._replies = {node: self.link.views[node].replies for node in self.link.nodes}
        self._window_start, self._lossy = self.link.syncs, set()

    def before_arming(self, boards: dict[int, set[int]] | None = None) -> list[Notice]:
        """Return what prevents arming the robot; ``boards`` is the result of a discovery, if there was one."""
        now = self.link.port.now()
        if not self.link.alive():
            return [Notice(0, "missing", f"no joint answers on {self.link.port.name}: {NOBODY}", "refuse")]
        found = [notice for node in self.link.nodes for notice in self._at_rest(self.link.views[node], now)]
        for node, numbers in sorted((boards or {}).items()):
            if node and len(numbers) > 1:
                text = f"{joint_name(node)}: {len(numbers)} boards have this node; change one: caramelo joints set-id"
                found.append(Notice(node, "duplicate", text, "refuse"))
        if boards is not None:
            found += [self._mute(node) for node in self.link.alive() if node not in boards]
        return found + self._mixed()

    @staticmethod
    def _mute(node: int) -> Notice:
        text = f"{joint_name(node)} is there but did not report its board's number: the bus loses frames; try again"
        return Notice(node, "mute", text, "refuse")

    def _at_rest(self, view: JointView, now: float) -> list[Notice]:
        name = joint_name(view.node)
        if now - view.heartbeat_s > HEARTBEAT_S:
            text = f"{name} is not there: check its power, the CAN cable and both terminators"
            return [Notice(view.node, "missing", text, "refuse")]
        if view.heartbeat.mode == w.MODE_UPDATING:
            text = f"{name} is getting new firmware: wait until that ends, or ten seconds after it broke off"
            return [Notice(view.node, "updating", text, "refuse")]
        theirs = view.heartbeat.protocol_hash
        if theirs != w.PROTOCOL_HASH:
            text = f"{name} speaks protocol {theirs:#06x}, this host {w.PROTOCOL_HASH:#06x}: run caramelo flash --can"
            return [Notice(view.node, "hash", text, "refuse")]
        if view.heartbeat.fault:
            return [Notice(view.node, "fault", f"{name}: {self.fault_text(view)}", "refuse")]
        return []

    def _mixed(self) -> list[Notice]:
        heard = [self.link.views[node] for node in self.link.nodes if self.link.views[node].heartbeat_s > -inf]
        builds = sorted({view.heartbeat.build for view in heard})
        if len(builds) < 2:
            return []
        counts = {build: [v.node for v in heard if v.heartbeat.build == build] for build in builds}
        told = "; ".join(f"build {build:06x} on nodes {', '.join(map(str, n))}" for build, n in counts.items())
        text = f"the joints have different firmware: {told}; caramelo flash --can --all gives all the same"
        return [Notice(0, "versions", text, "refuse")]

    def fault_text(self, view: JointView) -> str:
        """Return a joint's latched fault as a sentence with a hint."""
        code = view.heartbeat.fault
        known = view.fault.code == code
        if code and not known:
            return f"{fault_name(code)}; its fault record has not come yet; try again in a second"
        return fault_sentence(code, view.fault.value if known else 0, self._units)

    def while_armed(self) -> list[Notice]:
        """Return what has happened since arming; called every cycle."""
        now = self.link.port.now()
        self._count_losses()
        notices = (self._armed(self.link.views[node], now) for node in self.link.nodes)
        return [notice for notice in notices if notice is not None]

    def _armed(self, view: JointView, now: float) -> Notice | None:
        name, heartbeat = joint_name(view.node), view.heartbeat
        if heartbeat.fault == FAULT_DUPLICATE_ID:
            return Notice(view.node, "duplicate", f"{name}: another board has the same node", "damp")
        if heartbeat.fault:
            return Notice(view.node, "fault", f"{name}: {self.fault_text(view)}", "damp")
        if heartbeat.session != self.link.session:
            text = f"{name} was disarmed by another program, or was reset: check its supply"
            return Notice(view.node, "reset", text, "damp")
        if now - view.reply_s > SILENT_S:
            return Notice(view.node, "silent", f"{name} has not replied for {now - view.reply_s:.2f} s", "damp")
        if view.status.limits & _HOT:
            return Notice(view.node, "hot", f"{name} is hot and limits its current: let the robot sit and cool", "sit")
        if view.node in self._lossy:
            return Notice(view.node, "loss", f"{name}: more than a tenth of its replies is lost", "sit")
        return None

    def _count_losses(self) -> None:
        cycles = self.link.syncs - self._window_start
        if cycles < LOSS_WINDOW:
            return
        self._window_start = self.link.syncs
        replies = {node: self.link.views[node].replies for node in self.link.nodes}
        self._lossy = {n for n, count in replies.items() if count - self._replies[n] < (1 - LOSS_SHARE) * cycles}
        self._replies = replies
