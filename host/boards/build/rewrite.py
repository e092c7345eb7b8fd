"""Turns the neutral marks of the core into an emitter's own, by editing the text and not the layout.

Edits are made at the positions the syntax tree gives, lines stay where they are, so an error on
the board names the line of the source.
"""

import ast
from collections.abc import Mapping
from dataclasses import dataclass

from .rules import POINTERS, REGISTERS, aliases, check_hot, hot_function
from .source import Module, assignments, called, calls, has_no_result, is_name, stored_names

EMITTERS = ("bytecode", "native", "viper")


@dataclass(frozen=True)
class Edit:
    """Replace ``length`` bytes at ``offset`` by ``text``; ``rank`` orders edits at one place."""

    offset: int
    length: int
    text: str
    rank: int = 0


def rewrite(module: Module, modules: dict[str, Module], emitter: str, arch: str) -> bytes:
    """Return the module's text for ``emitter``; BuildError with file, line and rule if it breaks one.

    Every emitter: constants become their numbers in all functions. native and viper: the mark
    becomes the emitter's. native and bytecode: ptr16(x) becomes x. viper: a parameter that is only
    read through its alias becomes the pointer itself, results of hot functions become int(...),
    -> None goes, which it does not know, and on x64, where ptr32 reads unsigned, elements are
    sign-extended, and -x becomes (0 - x), because MicroPython's x64 viper (1.28) negates the local
    x itself.
    """
    place = Places(module.text)
    edits: list[Edit] = []
    for function in _functions(module.tree):
        edits += inline_constants(module, function, place)
    for function in module.hot_functions:
        check_hot(module, function, modules)
        if emitter != "bytecode":
            marks = [mark for mark in function.decorator_list if is_name(mark, "hot")]
            edits += [place.edit(mark, f"micropython.{emitter}") for mark in marks]
        if emitter != "viper":
            edits += _without_pointers(function, place)
            continue
        edits += _typed_parameters(function, place)
        edits += _wrap_calls(module, function, modules, place)
        edits += _name_registers(function, place)
        if has_no_result(function):
            edits.append(without_result(module, function, place))
        if arch == "x64":
            edits += _extend_signs(function, place)
            edits += _subtract_from_zero(function, place)
    text = apply_edits(module.text, edits)
    if emitter == "viper" and arch == "x64":
        text = _expand_augmented(module, text)
    return text


class Places:
    """Byte offsets of the nodes of one text."""

    def __init__(self, text: bytes) -> None:
        self._text = text
        self._lines = [0]
        for line in text.splitlines(keepends=True):
            self._lines.append(self._lines[-1] + len(line))

    def start(self, node: ast.AST) -> int:
        return self._lines[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]

    def end(self, node: ast.AST) -> int:
        return self._lines[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def edit(self, node: ast.AST, text: str) -> Edit:
        """Return the edit that puts ``text`` in the place of a node."""
        return Edit(self.start(node), self.end(node) - self.start(node), text)

    def statement(self, node: ast.stmt, text: str) -> Edit:
        """Return the edit that puts a line in the place of a statement and its marks; lines behind it do not move."""
        marks = node.decorator_list if isinstance(node, ast.FunctionDef | ast.ClassDef) else []
        start, end = self.start(marks[0]) - 1 if marks else self.start(node), self.end(node)
        return Edit(start, end - start, text + "\n" * self._text[start:end].count(b"\n"))

    def around(self, node: ast.AST, before: str, behind: str) -> list[Edit]:
        """Return the edits that put text before and behind a node."""
        return [Edit(self.start(node), 0, before, rank=-1), Edit(self.end(node), 0, behind, rank=1)]


def _functions(tree: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def beside(module: Module, owner: ast.Module | ast.FunctionDef, text: str, place: Places) -> Edit:
    """Put statements on a line that is there: behind the docstring, else before the first statement."""
    first = owner.body[0]
    if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
        return Edit(place.end(first), 0, f"; {text}")
    if hasattr(first, "body"):
        raise module.error(first, "a hot function that begins with a block needs a docstring before it")
    return Edit(place.start(first), 0, f"{text}; ", rank=-2)


def inline_constants(module: Module, function: ast.FunctionDef, place: Places) -> list[Edit]:
    """Numbers instead of names: saves a look-up in bytecode, and viper would see an object."""
    local = {a.arg for a in function.args.args} | stored_names(function)
    known = {name: value for name, value in module.constants.items() if name not in local}
    edits = []
    for statement in function.body:
        for node in ast.walk(statement):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in known:
                value = known[node.id]
                edits.append(place.edit(node, str(value) if value >= 0 else f"({value})"))
    return edits


def without_result(module: Module, function: ast.FunctionDef, place: Places) -> Edit:
    """Take the annotation of a result away: `` -> None``."""
    assert function.returns is not None
    arrow = module.text.rindex(b"->", 0, place.start(function.returns))
    return Edit(arrow - 1, place.end(function.returns) - arrow + 1, "")


def strip_pointers(function: ast.FunctionDef, place: Places) -> list[Edit]:
    """``ptr16(x)`` is x outside viper; without the call it costs nothing. Registers are of a model there, and stay."""
    edits = []
    for name, call in calls(function):
        if name in POINTERS:
            edits.append(Edit(place.start(call), place.start(call.args[0]) - place.start(call), ""))
            edits.append(Edit(place.end(call.args[0]), place.end(call) - place.end(call.args[0]), ""))
    return edits


def _without_pointers(function: ast.FunctionDef, place: Places) -> list[Edit]:
    """As strip_pointers; where a parameter's alias was, the parameter is used, and its frame gets smaller.

    A frame of more than eleven words is taken from MicroPython's heap, which costs more than the call itself.
    """
    renamed = _without_aliases(function, _parameters_behind(function), place)
    stripped = [edit for edit in strip_pointers(function, place)
                if not any(gone.offset <= edit.offset < gone.offset + gone.length for gone in renamed)]
    return stripped + renamed


def _typed_parameters(function: ast.FunctionDef, place: Places) -> list[Edit]:
    """Give a parameter that only its alias reads the alias's type: ``x: ptr32``, without ``_x = ptr32(x)``.

    Viper keeps its first parameters in registers, and other names in memory.
    """
    read = [node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)]
    parameters = {alias: name for alias, name in _parameters_behind(function).items() if read.count(name) == 1}
    kinds, places = aliases(function), {argument.arg: place.end(argument) for argument in function.args.args}
    types = [Edit(places[name], 0, f": {kinds[alias]}") for alias, name in parameters.items()]
    return types + _without_aliases(function, parameters, place)


def _parameters_behind(function: ast.FunctionDef) -> dict[str, str]:
    """Return the parameter behind each alias, where neither is ever set anew."""
    stored = [node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    given = {argument.arg for argument in function.args.args}.difference(stored)
    found = {}
    for name, value in assignments(function.body):
        behind = value.args[0] if isinstance(value, ast.Call) and called(value) in POINTERS else None
        if isinstance(behind, ast.Name) and behind.id in given and stored.count(name) == 1:
            found[name] = behind.id
    return found


def _without_aliases(function: ast.FunctionDef, parameters: Mapping[str, str], place: Places) -> list[Edit]:
    """Use the parameter in the place of each alias, and make no alias."""
    edits = []
    for node in ast.walk(function):
        target = node.targets[0] if isinstance(node, ast.Assign) else None
        if isinstance(target, ast.Name) and target.id in parameters:
            edits.append(place.edit(node, "pass"))
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in parameters:
            edits.append(place.edit(node, parameters[node.id]))
    return edits


def _name_registers(function: ast.FunctionDef, place: Places) -> list[Edit]:
    """``reg32(x)`` is ptr32(x): viper reads and writes memory each time it is told to."""
    return [Edit(place.start(call), len("reg"), "ptr") for name, call in calls(function) if name in REGISTERS]


def _wrap_calls(module: Module, function: ast.FunctionDef, modules: dict[str, Module], place: Places) -> list[Edit]:
    dropped = {id(node.value) for node in ast.walk(function) if isinstance(node, ast.Expr)}
    edits = []
    for name, call in calls(function):
        if id(call) not in dropped and hot_function(module, name, modules) is not None:
            edits += place.around(call, "int(", ")")
    return edits


def _signed_elements(function: ast.FunctionDef) -> list[ast.Subscript]:
    """Return the elements that are read or set through a ptr32."""
    signed = {name for name, kind in aliases(function).items() if kind == "ptr32"}
    return [node for node in ast.walk(function)
            if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in signed]


def _extend_signs(function: ast.FunctionDef, place: Places) -> list[Edit]:
    edits = []
    for element in _signed_elements(function):
        if isinstance(element.ctx, ast.Load):
            edits += place.around(element, "((", " << 32) >> 32)")
    return edits


def _subtract_from_zero(function: ast.FunctionDef, place: Places) -> list[Edit]:
    edits = []
    for node in ast.walk(function):
        negates = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
        if negates and not isinstance(node.operand, ast.Constant):  # type: ignore[attr-defined]
            edits.append(Edit(place.start(node), 1, "(0 - "))
            edits.append(Edit(place.end(node), 0, ")", rank=2))
    return edits


def _expand_augmented(module: Module, text: bytes) -> bytes:
    """``p[i] >>= n`` would shift the unsigned word: spell it with a sign-extended read (x64 only)."""
    tree = ast.parse(text, module.path)
    place = Places(text)
    signs = {ast.RShift: ">>", ast.FloorDiv: "//", ast.Mod: "%"}
    edits = []
    for function in _functions(tree):
        elements = _signed_elements(function)
        for node in ast.walk(function):
            if isinstance(node, ast.AugAssign) and type(node.op) in signs and node.target in elements:
                start, value = place.end(node.target), place.start(node.value)
                again = text[place.start(node.target) : start].decode()
                sign = signs[type(node.op)]
                edits.append(Edit(start, value - start, f" = (({again} << 32) >> 32) {sign} ("))
                edits.append(Edit(place.end(node), 0, ")", rank=1))
    return apply_edits(text, edits)


def apply_edits(text: bytes, edits: list[Edit]) -> bytes:
    result, at = [], 0
    for edit in sorted(set(edits), key=lambda e: (e.offset, e.rank)):
        result += [text[at : edit.offset], edit.text.encode()]
        at = edit.offset + edit.length
    return b"".join([*result, text[at:]])
