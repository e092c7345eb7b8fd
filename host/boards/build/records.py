"""Where the fields of records lie: every class marked ``@record`` (shared/record.py) as places in one array."""

import ast
from dataclasses import dataclass, field
from typing import Any

from .source import Module, constant_value, resolve

_KINDS = ("field", "vector", "part", "parts")


@dataclass(frozen=True)
class Place:
    """A field: where it begins, how many values it has (None: one) and of what record; its declaration."""

    at: int
    count: int | None
    of: "Layout | None"
    default: int
    unit: str
    meaning: str

    @property
    def size(self) -> int:
        """Return how many integers it takes."""
        return (self.of.size if self.of else 1) * (1 if self.count is None else self.count)


@dataclass
class Layout:
    """A record: its fields in the order of their declaration, one behind the other."""

    name: str
    places: dict[str, Place] = field(default_factory=dict)
    size: int = 0
    numbered: bool = False  # an Axes: its fields are read by number, too

    def defaults(self) -> list[int]:
        """Return the integers of a new one."""
        made: list[int] = []
        for place in self.places.values():
            one = place.of.defaults() if place.of else [place.default]
            made += one * (1 if place.count is None else place.count)
        return made


class Layouts:
    """The records of all modules, read when first asked for."""

    def __init__(self, modules: dict[str, Module]) -> None:
        self._modules = modules
        self._known: dict[tuple[str, str], Layout] = {}

    def find(self, module: Module, name: str) -> Layout | None:
        """Return the record that ``module`` knows as ``name``; None if that is none. BuildError if it is malformed."""
        found = resolve(module, name, self._modules)
        if found is None:
            return None
        key = (found[0].name, found[1])
        if key not in self._known:
            declared = next((n for n in records_of(found[0].tree) if n.name == found[1]), None)
            if declared is None:
                return None
            self._known[key] = self._read(found[0], declared)
        return self._known[key]

    def names(self) -> set[str]:
        """Return the names of all fields of all records."""
        return {statement.target.id for module in self._modules.values() for declared in records_of(module.tree)
                for statement in declared.body
                if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)}

    def _read(self, module: Module, declared: ast.ClassDef) -> Layout:
        made = Layout(declared.name, numbered=bool(declared.bases))
        for statement in declared.body:
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                continue  # its docstring
            name, place = self._place(module, statement, made.size)
            if made.numbered and (place.of or place.count is not None):
                raise module.error(statement, f"{made.name} is an Axes: it has single integers only")
            made.places[name] = place
            made.size += place.size
        return made

    def _place(self, module: Module, statement: ast.stmt, at: int) -> tuple[str, Place]:
        if not (isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
                and isinstance(statement.value, ast.Call) and isinstance(statement.value.func, ast.Name)
                and statement.value.func.id in _KINDS):
            raise module.error(statement, "a record holds lines `name: int = field(unit, meaning)` "
                                          "and the like of vector, part and parts, nothing else")
        call, kind = statement.value, statement.value.func.id
        values = [*call.args, *(word.value for word in call.keywords)]
        many = kind in ("vector", "parts")
        count = _number(module, values.pop(0)) if many else None
        of = None
        if kind in ("part", "parts"):
            inner = values.pop(0)
            of = self.find(module, inner.id) if isinstance(inner, ast.Name) else None
            if of is None:
                raise module.error(inner, f"{ast.unparse(inner)} is not a record")
        wanted = 1 if of else 2
        if len(values) < wanted:
            raise module.error(call, "a field has a unit and a meaning, a part a meaning")
        words = [value.value for value in values if isinstance(value, ast.Constant) and isinstance(value.value, str)]
        default = 0 if of or len(values) < 3 else _number(module, values[2])
        return statement.target.id, Place(at, count, of, default, "" if of else words[0], words[-1])


def records_of(tree: ast.Module) -> list[ast.ClassDef]:
    """Return the classes of a module marked ``@record``."""
    return [node for node in tree.body if isinstance(node, ast.ClassDef) and any(
        isinstance(mark, ast.Name) and mark.id == "record" for mark in node.decorator_list)]


def place_of(declared: Any, name: str) -> int:
    """Return where a field of a record's class begins in the array that the build makes of it; not behind records."""
    at = 0
    for known, declaration in declared.FIELDS:
        if known == name:
            return at
        at += declaration.count or 1
    raise KeyError(name)


def _number(module: Module, node: ast.expr) -> int:
    value = constant_value(node, module.constants)
    if value is None:
        raise module.error(node, f"{ast.unparse(node)} does not follow from literals and constants")
    return value
