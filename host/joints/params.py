"""A joint's parameters over the bus, by name and in their own units (host/protocol/parameters.toml)."""

from collections.abc import Sequence

from shared.wire import names as w

from ..errors import UserError
from ..protocol.parameters import Parameter, ParameterError, load
from .service import Requests


def find_all(names: Sequence[str] | None) -> list[Parameter]:
    """Return parameters by name, all without names; UserError for one that does not exist."""
    known = {parameter.name: parameter for parameter in load()}
    for name in names or ():
        if name not in known:
            near = [other for other in known if name.split("_")[0] in other][:5]
            raise UserError(f"{name}: no such parameter" + (f"; there are {', '.join(near)}" if near else ""))
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


def differences(requests: Requests, node: int) -> list[tuple[Parameter, int]]:
    """Return the kept parameters that are not a fresh board's, with their raw values."""
    rows = [(parameter, read(requests, node, parameter)) for parameter in load() if parameter.stored]
    return [(parameter, raw) for parameter, raw in rows if raw != parameter.default]
