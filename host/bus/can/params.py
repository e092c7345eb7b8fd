"""A joint's parameters over the bus, by name and in their own units (host/protocol/parameters.toml)."""

from collections.abc import Mapping, Sequence

from shared.wire import names as w

from ...protocol.parameters import Parameter, ParameterError, load
from ...util.errors import UserError
from .param_file import kept
from .service import Requests


def find_all(names: Sequence[str] | None) -> list[Parameter]:
    """Return parameters by name, all if there is no name; UserError for one that does not exist."""
    known = {parameter.name: parameter for parameter in load()}
    for name in names or ():
        if name not in known:
            near = [other for other in known if name.split("_")[0] in other][:5]
            some = f"there are {', '.join(near)}" if near else "caramelo joints params get NODE lists them"
            raise UserError(f"{name}: no such parameter; {some}")
    return [known[name] for name in names] if names else list(known.values())


def read(requests: Requests, node: int, parameter: Parameter) -> int:
    """Return the raw value."""
    return requests.demand(node, w.COMMAND_READ_PARAMETER, parameter.id).value


def write(requests: Requests, node: int, parameter: Parameter, value: float) -> int:
    """Write a value in the parameter's unit, read it back, and return it raw."""
    try:
        raw = parameter.to_raw(value)
    except ParameterError as error:
        raise UserError(str(error)) from error
    requests.demand(node, w.COMMAND_WRITE_PARAMETER, parameter.id, raw)
    return read(requests, node, parameter)


def read_kept(requests: Requests, node: int) -> dict[str, int]:
    """Return the raw values of the saved parameters, except the node itself."""
    return {parameter.name: read(requests, node, parameter) for parameter in kept()}


def write_kept(requests: Requests, node: int, values: Mapping[str, int]) -> int:
    """Write raw values by name where they differ; return how many did."""
    changed = 0
    for parameter in kept():
        if parameter.name in values and read(requests, node, parameter) != values[parameter.name]:
            requests.demand(node, w.COMMAND_WRITE_PARAMETER, parameter.id, values[parameter.name])
            changed += 1
    return changed


def differences(
    requests: Requests, node: int, wanted: Mapping[str, int] | None = None
) -> list[tuple[Parameter, int, int]]:
    """Return the saved parameters that differ from a file's or a fresh board's: raw value, and raw wanted one."""
    expected = {parameter.name: parameter.default for parameter in kept()} if wanted is None else wanted
    rows = [(p, read(requests, node, p), expected[p.name]) for p in kept() if p.name in expected]
    return [row for row in rows if row[1] != row[2]]
