"""The core with types, for mypyc: what makes a C compiler's work of it is what makes viper's (rules.py).

A hot function has numbers, pointers to arrays and nothing else, and its marks tell which is which. Written out as
types they turn CPython's core into machine code; nothing that is computed changes, and no line moves.
"""

import ast

from .kinds import TABLES, Kinds
from .lower import Lowering, lower
from .records import Layout, records_of
from .rewrite import Edit, Places, apply_edits, beside, inline_constants, strip_pointers
from .rules import aliases, check_hot
from .source import Module, has_no_result

NUMBER = "i64"  # holds every intermediate, which are within 30 bits; leaving 64 would raise OverflowError
_TABLE = "tuple[int, ...]"  # what table() and words() leave
_ARRAY = "list[int]"  # what zeros() makes, read without asking what it is
_ANY = "Any"
_IMPORTS = f"from typing import Any; from mypy_extensions import {NUMBER}"


def typed_modules(modules: dict[str, Module], package: str = "shared") -> dict[str, bytes]:
    """Return the text of every module but packages with types, by name; BuildError with file, line and the rule.

    ``package``: what the core is imported as.
    """
    for module in lower(modules).values():
        for function in module.hot_functions:
            check_hot(module, function, modules)
    kinds = Kinds(modules)
    return {name: _typed(module, kinds, package) for name, module in modules.items() if not module.is_package}


def _typed(module: Module, kinds: Kinds, package: str) -> bytes:
    place = Places(module.text)
    declares = f"; from typing import ClassVar; from {package}.record import Field" if records_of(module.tree) else ""
    edits = [beside(module, module.tree, _IMPORTS + declares, place)]
    for declared in records_of(module.tree):
        layout = kinds.layouts.find(module, declared.name)
        assert layout is not None
        edits.append(_type_record(module, declared, layout, place))
    edits += [Edit(place.start(node.annotation), len("Ints"), _ARRAY) for node in ast.walk(module.tree)
              if isinstance(node, ast.arg) and isinstance(node.annotation, ast.Name) and node.annotation.id == "Ints"]
    for function in module.hot_functions:
        edits += inline_constants(module, function, place)
        edits += strip_pointers(function, place)
        edits += _unmark(function, place)
        edits += _type_signature(function, place)
        known = Lowering(module, kinds, set(), place).known(function)
        local = _locals(function)
        local |= {name: _TABLE for name in local if name in known and known[name].kind in TABLES}
        names = "; ".join(f"{name}: {kind}" for name, kind in local.items() if name not in known or kind == _TABLE)
        if names:
            edits.append(beside(module, function, names, place))
    return apply_edits(module.text, edits)


def _type_record(module: Module, declared: ast.ClassDef, layout: Layout, place: Places) -> Edit:
    """A record as a native class: its lists are made anew for each object."""
    names, makes, fields = [], [], []
    for name, field in layout.places.items():
        kind = field.of.name if field.of else "int"
        made = f"{field.of.name}()" if field.of else str(field.default)
        if field.count is not None:
            kind = f"list[{kind}]"
            made = f"[{made} for _ in range({field.count})]"
        of = field.of.name if field.of else None
        fields.append(f"({name!r}, Field({field.unit!r}, {field.meaning!r}, {field.default}, {field.count}, {of}))")
        names.append(f"{name}: {kind}")
        makes.append(f"self.{name} = {made}")
    start, end = place.start(declared.decorator_list[0]) - 1, place.end(declared)
    lines = [f"class {declared.name}:",
             f"    FIELDS: ClassVar[Any] = ({''.join(f'{one}, ' for one in fields)}); {'; '.join(names)}",
             f"    def __init__(self) -> None: {'; '.join(makes)}"]
    if layout.numbered:
        lines += _numbered(list(layout.places))
    text = "\n".join(lines)
    return Edit(start, end - start, text + "\n" * (module.text[start:end].count(b"\n") + 1 - len(lines)))


def _numbered(names: list[str]) -> list[str]:
    """Return the methods that read and write fields by number: a chain of comparisons, which is fast in C."""
    last = len(names) - 1
    chain = "".join(f"self.{name} if axis == {at} else " for at, name in enumerate(names[:-1]))
    return [f"    def __getitem__(self, axis: {NUMBER}) -> int: return {chain}[self.{names[-1]}][axis - {last}]",
            f"    def __setitem__(self, axis: {NUMBER}, value: int) -> None: "
            + "; ".join(f"self.{name} = value if axis == {at} else self.{name}" for at, name in enumerate(names))]


def _unmark(function: ast.FunctionDef, place: Places) -> list[Edit]:
    """Take ``@hot`` away: a decorated function is an object, looked up and called as one."""
    marks = [mark for mark in function.decorator_list if isinstance(mark, ast.Name) and mark.id == "hot"]
    return [Edit(place.start(mark) - 1, len("@hot"), "") for mark in marks]


def _type_signature(function: ast.FunctionDef, place: Places) -> list[Edit]:
    edits = []
    for parameter in function.args.args:
        if isinstance(parameter.annotation, ast.Name) and parameter.annotation.id == "int":
            edits.append(Edit(place.start(parameter.annotation), len("int"), NUMBER))
        elif parameter.annotation is None:
            edits.append(Edit(place.end(parameter), 0, f": {_ANY}"))
    assert function.returns is not None  # check_hot saw to that
    if not has_no_result(function):
        edits.append(Edit(place.start(function.returns), len("int"), NUMBER))
    return edits


def _locals(function: ast.FunctionDef) -> dict[str, str]:
    """Return every local name with its type: anything for a pointer, which a frame or a table of the wire is."""
    given = {parameter.arg for parameter in function.args.args}
    stored = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    pointers = aliases(function)
    return {name: _ANY if name in pointers else NUMBER for name in sorted(stored - given)}
