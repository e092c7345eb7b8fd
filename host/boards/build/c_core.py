"""The hot functions of the core as one C file, and the rest of its modules as they are without them.

An image for a board is built from MicroPython's sources, so the machine code of its core can be made by the compiler
that makes MicroPython's: a module ``_core`` in C takes the place of every function marked ``@hot``. What calls one
from ordinary Python finds it where it was, by an import; what only hot functions use is gone from the modules, and
with it the memory for its names.
"""

import ast
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from .c_holders import converted, holders_text, room_of
from .c_source import FunctionWriter, c_name, signature
from .rewrite import Edit, Places, apply_edits, inline_constants
from .rules import check_hot
from .source import BuildError, Module, assignments, called, closure, constant_value, find_imports, has_no_result

MODULE = "_core"
_HEADS = {"micropython": "c_micropython.h", "cpython": "c_cpython.h"}
_ARRAYS = {"H": "uint16_t", "i": "int32_t", "B": "uint8_t"}
_TABLES = {"table": "H", "words": "i", "array": ""}  # what makes a constant array, and the kind of its numbers
_ARITHMETIC = """
static inline int32_t core_floor(int32_t a, int32_t b) {
    if (b == 0) return 0;
    int32_t q = a / b;
    return q - (a % b != 0 && (a < 0) != (b < 0));
}
static inline int32_t core_modulo(int32_t a, int32_t b) {
    if (b == 0) return 0;
    int32_t r = a % b;
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}
"""


@dataclass(frozen=True)
class CCore:
    """``source``: the C file. ``modules``: the text of every other module by its path."""

    source: str
    modules: dict[str, bytes]


def build_c_core(modules: dict[str, Module], names: Iterable[str], runtime: str, whole: bool = False) -> CCore:
    """Return ``names`` of ``modules`` and all they import in two parts. BuildError names file, line and rule.

    runtime: ``micropython`` or ``cpython``. ``whole``: expose every hot function and keep every name and module, for
    tests; else only what ordinary Python uses.
    """
    seeds = list(names)
    chosen = [modules[name] for name in closure(modules, seeds)]
    wanted = None if whole else _names_in_use(chosen, modules)
    texts = {module.path: cold_text(module, wanted) for module in chosen}
    if not whole:
        texts = _still_imported(modules, seeds, texts)
    return CCore(c_text(chosen, modules, runtime, wanted), texts)


def _still_imported(modules: dict[str, Module], seeds: list[str], texts: dict[str, bytes]) -> dict[str, bytes]:
    """Leave out modules that held nothing but hot functions and what these use."""
    left = {module.name: replace(module, tree=ast.parse(texts[module.path]), needs=set(), imports={})
            for module in modules.values() if module.path in texts}
    for module in left.values():
        find_imports(module, left)
    return {modules[name].path: texts[modules[name].path] for name in closure(left, seeds)}


def c_text(chosen: list[Module], modules: dict[str, Module], runtime: str, wanted: set[tuple[str, str]] | None) -> str:
    """Return the C file for the hot functions of ``chosen``."""
    heads, bodies, exposed = [], [], []
    tables: dict[str, tuple[Module, str]] = {}
    for module in chosen:
        for function in module.hot_functions:
            check_hot(module, function, modules)
            writer = FunctionWriter(module, function, modules)
            heads.append(f"{signature(module, function)};")
            bodies.append(writer.write())
            tables |= writer.tables
            if wanted is None or (module.name, function.name) in wanted:
                exposed.append((module, function))
    parts = [(Path(__file__).parent / _HEADS[runtime]).read_text(), _ARITHMETIC]
    parts += [_table(name, *found) for name, found in sorted(tables.items())]
    parts.append(holders_text(chosen, modules))
    parts += ["\n".join(heads), *bodies, *(_expose(*pair) for pair in exposed), _module(exposed)]
    return "\n".join(parts)


def _expose(module: Module, function: ast.FunctionDef) -> str:
    name, given = c_name(module.name, function.name), function.args.args
    kind = "CORE_SILENT" if has_no_result(function) else "CORE_RESULT"
    if not given:
        return f"CORE_EXPOSE_0({name}, {kind})"
    blocks = module.blocks.get(function.name, {})
    kinds = [blocks.get(p.arg) for p in given]
    values = [f"CORE_NUMBER(a[{i}])" if p.annotation else converted(f"a[{i}]", kind, room_of(kind))
              for i, (p, kind) in enumerate(zip(given, kinds, strict=True))]
    return f"CORE_EXPOSE_N({name}, {kind}, {len(given)}, {', '.join(values)})"


def _module(exposed: list[tuple[Module, ast.FunctionDef]]) -> str:
    entries = [f"    CORE_ENTRY({c_name(module.name, function.name)})" for module, function in exposed]
    lines = ["#define CORE_ENTRIES", *entries]
    return " \\\n".join(lines) + "\n\nCORE_MODULE(CORE_ENTRIES)\n"


def _table(name: str, module: Module, original: str) -> str:
    """Return a constant array: ``NAME = table((...))``, ``words((...))`` or ``array("i", (...))``."""
    call = next((value for known, value in assignments(module.tree.body) if known == original), None)
    if not isinstance(call, ast.Call) or called(call) not in _TABLES:
        raise BuildError(f"{module.path}: {original} is read by a hot function, but is no table of numbers")
    code = _TABLES[called(call)] or ast.literal_eval(call.args[0])
    elements = call.args[-1]
    assert isinstance(elements, ast.Tuple | ast.List)
    values = [constant_value(element, module.constants) for element in elements.elts]
    if code not in _ARRAYS or None in values:
        raise module.error(call, f"{original}: a table holds numbers that follow from literals and constants")
    return f"static const {_ARRAYS[code]} {name}[] = {{{', '.join(map(str, values))}}};"


# What is left of the modules


def cold_text(module: Module, wanted: set[tuple[str, str]] | None) -> bytes:
    """Return a module without its hot functions; lines stay where they are.

    ``wanted``: (module, name) of everything that ordinary Python uses; None keeps all names.
    """
    place = Places(module.text)
    edits: list[Edit] = []
    hot = module.hot_functions
    inside = {id(node) for function in hot for node in ast.walk(function)}
    for function in ast.walk(module.tree):
        if isinstance(function, ast.FunctionDef) and id(function) not in inside:
            edits += inline_constants(module, function, place)
    for function in hot:
        used = wanted is None or (module.name, function.name) in wanted
        text = f"from {MODULE} import {c_name(module.name, function.name)} as {function.name}" if used else ""
        edits.append(place.statement(function, text))
    if wanted is not None:
        _refuse_through_modules(module)
        edits += _drop_unused(module, wanted, place)
    return apply_edits(module.text, edits)


def _refuse_through_modules(module: Module) -> None:
    """What is asked of a module by name is not counted as used, and would be gone when it is asked for."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in module.aliases:
            raise module.error(node, f"{ast.unparse(node)}: import the name {node.attr}, not its module")


def _drop_unused(module: Module, wanted: set[tuple[str, str]], place: Places) -> list[Edit]:
    """Leave out imported names, constants and tables that nothing cold uses any more."""
    edits = []
    for node in module.tree.body:
        if isinstance(node, ast.ImportFrom) and node.names[0].name != "*":
            kept = [a for a in node.names if (module.name, a.asname or a.name) in wanted]
            if len(kept) < len(node.names):
                names = ", ".join(f"{a.name} as {a.asname}" if a.asname else a.name for a in kept)
                origin = "." * node.level + (node.module or "")
                edits.append(place.statement(node, f"from {origin} import {names}" if kept else ""))
        elif (name := _data_name(node)) and (module.name, name) not in wanted:
            edits.append(place.statement(node, ""))
    return edits


def _data_name(node: ast.stmt) -> str | None:
    """Return the name that a statement gives to a constant or a table, which nothing happens by; None of others."""
    return next((name for name, value in assignments([node]) if called(value) in ("const", *_TABLES)), None)


def _names_in_use(chosen: list[Module], modules: dict[str, Module]) -> set[tuple[str, str]]:
    """Return (module, local name) of everything ordinary Python reads, followed through imports to its origin."""
    waiting = [(module.name, name) for module in chosen for name in _read_when_cold(module)]
    found: set[tuple[str, str]] = set()
    while waiting:
        at = waiting.pop()
        if at in found or at[0] not in modules:
            continue
        found.add(at)
        module, name = modules[at[0]], at[1]
        if name in module.imports:
            waiting.append(module.imports[name])
        for node in module.tree.body:  # a constant's or a table's own names
            if _data_name(node) == name:
                waiting += [(module.name, n.id) for n in ast.walk(node) if isinstance(n, ast.Name)]
    return found


def _read_when_cold(module: Module) -> set[str]:
    """Return the names that a module reads outside of hot functions, apart from constants read in functions."""
    hot = {id(node) for function in module.hot_functions for node in ast.walk(function)}
    used: set[str] = set()
    for statement in module.tree.body:
        if _data_name(statement) or id(statement) in hot or isinstance(statement, ast.ImportFrom | ast.Import):
            continue
        functions = [node for node in ast.walk(statement) if isinstance(node, ast.FunctionDef)]
        inner = {id(node) for function in functions for inside in function.body for node in ast.walk(inside)}
        for node in ast.walk(statement):
            if isinstance(node, ast.Name) and id(node) not in hot and not (
                    id(node) in inner and node.id in module.constants):
                used.add(node.id)
    return used


