"""A joint's last report as a row; all rows as a table, with curves of their last seconds and the faults below it."""

from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ...bus.can.joints import CanJoints
    from ...bus.can.link import JointView

HOMELESS = "does not know its angle yet: put the robot into its sitting pose, where arm and teleop home it"
BARS = "▁▂▃▄▅▆▇█"
KEPT = 40  # values of a curve, one per refresh


def _row(bus: "CanJoints", view: "JointView") -> dict[str, Any]:
    from math import isinf

    from shared.record import pack
    from shared.wire import names as w

    from ...bus.can.service import joint_name
    from ...protocol.frames import describe, encode

    age_s = bus.now() - view.heartbeat_s
    if isinf(age_s) or age_s > 1.0:
        return {"joint": joint_name(view.node), "state": "not there", "fault": "check its power and the CAN cable"}
    heartbeat = describe(w.HEARTBEAT_ID + view.node, encode(w.HEARTBEAT_ID + view.node, pack(view.heartbeat))[0]) or {}
    slow = describe(w.SLOW_STATUS_ID + view.node, encode(w.SLOW_STATUS_ID + view.node, pack(view.status))[0]) or {}
    position = view.reply.position
    return {
        "joint": joint_name(view.node),
        "state": view.state_words,
        "mode": heartbeat["mode"],
        "motor_deg": None if position == w.NOT_AVAILABLE else round(position * 360 / 65536, 2),
        "current_A": round(view.reply.current / 4096, 3),
        "bus_V": slow["bus_voltage"],
        "winding_C": slow["winding_temperature"],
        "board_C": slow["mcu_temperature"],
        "limits": slow["limits"],
        "lost": view.lost,
        "late": view.late,
        "fault": bus.cycle.guard.fault_text(view) if view.heartbeat.fault else "none",
        "remark": HOMELESS if position == w.NOT_AVAILABLE else "",
    }


# Column -> its heading; faults are sentences, so they stand below the table
_COLUMNS = {
    "state": "state",
    "motor_deg": "deg",
    "current_A": "A",
    "bus_V": "V",
    "winding_C": "C",
    "limits": "limits",
    "lost": "lost",
    "late": "late",
}


def rows_of(bus: "CanJoints") -> list[dict[str, Any]]:
    return [_row(bus, bus.link.views[node]) for node in bus.link.nodes]


def table(rows: list[dict[str, Any]], plotted: str = "", curves: Sequence[str] = ()) -> Any:
    """Return the rows as a table, with a curve for each if there are curves."""
    from rich.console import Group
    from rich.text import Text

    from ...util.console import make_table

    shown = []
    for i, row in enumerate(rows):
        cells = (row.get(key) for key in _COLUMNS)
        told = ["-" if v is None else f"{v:.1f}" if isinstance(v, float) else str(v) for v in cells]
        shown.append((str(row["joint"]).replace("node ", ""), *told, *curves[i : i + 1]))
    wrong = [Text(f"{row['joint']}: {row['fault']}") for row in rows if row["fault"] != "none"]
    wrong += [Text(f"{row['joint']}: {row['remark']}") for row in rows if row.get("remark")]
    return Group(make_table(("joint", *_COLUMNS.values(), *filter(None, [plotted])), shown), *wrong)


def spark(values: Sequence[float | None], least_span: float) -> str:
    """Return one bar per value, a space where it is unknown; a span below ``least_span`` does not fill the height."""
    known = [value for value in values if value is not None]
    if not known:
        return ""
    low, high = min(known), max(known)
    span = max(high - low, least_span)
    return "".join(" " if v is None else BARS[min(len(BARS) - 1, int((v - low) / span * len(BARS)))] for v in values)


class Curves:
    """The last values of many things by name."""

    def __init__(self, least_span: float) -> None:
        self._least_span = least_span
        self._kept: dict[str, deque[float | None]] = {}

    def add(self, name: str, value: float | None) -> str:
        """Take a value and return its curve."""
        curve = self._kept.setdefault(name, deque(maxlen=KEPT))
        curve.append(value)
        return spark(list(curve), self._least_span)
