"""`caramelo joints params`: reads, writes, keeps and compares a joint's parameters."""

from typing import Annotated

import typer

from ...console import screen, write_json
from .options import Channel, Interface, Json, Node, RobotName, Sim, joints, print_table


def get(
    node: Node,
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME ...]", help="Without any: all.")] = None,
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Read parameters of a joint, in their own units.

    Example: caramelo joints params get 5 current_kp gear_q8 --sim
    """
    from ...joints.params import find_all, read

    wanted = find_all(names)
    with joints(robot, interface, channel, sim) as bus:
        values = {p.name: p.to_value(read(bus.requests, node, p)) for p in wanted}
    if as_json:
        write_json({"node": node, "parameters": values})
    else:
        print_table(("parameter", "value", "unit"), [(p.name, f"{values[p.name]:.10g}", p.unit) for p in wanted])
    return 0


def set_(
    node: Node,
    name: Annotated[str, typer.Argument(metavar="NAME")],
    value: Annotated[float, typer.Argument(metavar="VALUE", help="In the parameter's unit.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Write one parameter of a joint until it loses power; params save keeps it.

    Example: caramelo joints params set 5 position_p 900
    """
    from ...joints.params import find_all, write

    with joints(robot, interface, channel, sim) as bus:
        raw = write(bus.requests, node, find_all([name])[0], value)
    screen().print(f"node {node}: {name} is raw {raw} now; params save keeps it")
    return 0


def save(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Keep a joint's parameters over a power cycle.

    Example: caramelo joints params save 5
    """
    from shared.wire import names as w

    with joints(robot, interface, channel, sim) as bus:
        bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"node {node}: parameters are kept")
    return 0


def restore(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Set a joint's parameters back to those of a fresh board, until it loses power; params save keeps them.

    Example: caramelo joints params restore 5
    """
    from shared.wire import names as w

    with joints(robot, interface, channel, sim) as bus:
        bus.requests.demand(node, w.COMMAND_RESTORE_DEFAULTS)
    screen().print(f"node {node}: parameters are those of a fresh board; params save keeps them")
    return 0


def diff(
    node: Node, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Show where a joint's parameters differ from a fresh board's.

    Example: caramelo joints params diff 5 --sim
    """
    from ...joints.params import differences

    with joints(robot, interface, channel, sim) as bus:
        rows = differences(bus.requests, node)
    if as_json:
        write_json(
            {"node": node, "different": [{"parameter": p.name, "raw": raw, "fresh": p.default} for p, raw in rows]}
        )
    else:
        print_table(
            ("parameter", "raw", "fresh board", "unit of raw"), [(p.name, raw, p.default, p.unit) for p, raw in rows]
        )
    return 0
