"""A joint's last report as a row, and all rows as a table with the faults in sentences below it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ...bus.can.joints import CanJoints
    from ...bus.can.link import JointView

HOMELESS = "does not know its angle yet: put the robot into its sitting pose, where arm and teleop home it"


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
