"""`caramelo joints params`: reads, writes, saves and compares a joint's parameters."""

from pathlib import Path
from typing import Annotated

import typer

from ...util.console import print_table, screen, write_json
from .options import Channel, Interface, Json, Node, RobotName, Sim, joints

GROUP = typer.Typer(help="Read, write, save and compare the joints' parameters.", no_args_is_help=True)
File = Annotated[Path | None, typer.Option("--file", metavar="FILE", help="A file that params save has written.")]


@GROUP.command()
def get(
    node: Node,
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME ...]", help="Default: all.")] = None,
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Read parameters of a joint, in their units.

    Example: caramelo joints params get 5 current_kp gear_q8 --sim
    """
    from ...bus.can.params import find_all, read

    wanted = find_all(names)
    with joints(robot, interface, channel, sim) as bus:
        values = {p.name: p.to_value(read(bus.requests, node, p)) for p in wanted}
    if as_json:
        write_json({"node": node, "parameters": values})
    else:
        print_table(("parameter", "value", "unit"), [(p.name, f"{values[p.name]:.10g}", p.unit) for p in wanted])
    return 0


@GROUP.command("set")
def set_(
    node: Node,
    name: Annotated[str, typer.Argument(metavar="NAME")],
    value: Annotated[float, typer.Argument(metavar="VALUE", help="In the parameter's unit.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Write one parameter of a joint. It lasts until the joint loses power; params save makes it permanent.

    Example: caramelo joints params set 5 position_p 9
    """
    from ...bus.can.params import find_all, write

    with joints(robot, interface, channel, sim) as bus:
        parameter = find_all([name])[0]
        raw = write(bus.requests, node, parameter, value)
    now = f"{parameter.to_value(raw):.10g} {parameter.unit}".rstrip()
    screen().print(f"node {node}: {name} is now {now} (raw {raw}); params save makes it permanent")
    return 0


@GROUP.command()
def save(
    node: Node, file: File = None, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Make a joint's parameters permanent, so that they survive a power cycle; with --file also write them to a file.

    Examples: caramelo joints params save 5; caramelo joints params save 5 --file joint5.json
    """
    from shared.wire import names as w

    from ...bus.can.param_file import write_file
    from ...bus.can.params import read_kept

    with joints(robot, interface, channel, sim) as bus:
        if file is not None:
            write_file(file, node, read_kept(bus.requests, node))
        bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"node {node}: parameters saved" + (f", also to {file}" if file else ""), soft_wrap=True)
    return 0


@GROUP.command()
def restore(
    node: Node, file: File = None, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Set a joint's parameters to a file's or a fresh board's. They last until it loses power, unless params save runs.

    Examples: caramelo joints params restore 5; caramelo joints params restore 5 --file joint5.json
    """
    from shared.wire import names as w

    from ...bus.can.param_file import read_file
    from ...bus.can.params import write_kept

    values = None if file is None else read_file(file)
    with joints(robot, interface, channel, sim) as bus:
        if values is None:
            bus.requests.demand(node, w.COMMAND_RESTORE_DEFAULTS)
            what = "those of a fresh board"
        else:
            what = f"those of {file}, {write_kept(bus.requests, node, values)} changed"
    screen().print(f"node {node}: parameters are {what}; params save makes them permanent", soft_wrap=True)
    return 0


@GROUP.command()
def diff(
    node: Node, file: File = None, robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None,
    sim: Sim = False, as_json: Json = False,
) -> int:  # fmt: skip
    """Show where a joint's parameters differ from a file's, or from a fresh board's.

    Examples: caramelo joints params diff 5 --sim; caramelo joints params diff 5 --file joint5.json
    """
    from ...bus.can.param_file import read_file
    from ...bus.can.params import differences

    wanted, name = (None, "fresh board") if file is None else (read_file(file), "file")
    with joints(robot, interface, channel, sim) as bus:
        rows = differences(bus.requests, node, wanted)
    if as_json:
        different = [{"parameter": p.name, "raw": raw, "wanted": other} for p, raw, other in rows]
        write_json({"node": node, "beside": name, "different": different})
    else:
        print_table(("parameter", "raw", name, "unit of raw"), [(p.name, raw, other, p.unit) for p, raw, other in rows])
    return 0
