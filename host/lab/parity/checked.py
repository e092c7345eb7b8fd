"""Runs the core on an integer that refuses to leave -2^30 .. 2^30-1, and keeps the largest value met.

CPython never shows what a 32-bit MicroPython would allocate. Here every integer of shared/ is a
``Checked``: literals by a change to the syntax tree at import, array elements and loop counters
by arrays and ranges that hand out Checked, results because every operator returns Checked. A
float, a shift by 32 or more, or a value of more than 31 bits is an error at the place where it
arises. Numbers that a module's source names are tried as inputs too, with their neighbours and the powers of two:
a mistake for one value only has to name it. Runs by itself in a folder that holds ``shared`` and ``probe`` (see
sources.py).
"""

import array as plain_array
import ast
import builtins
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

WALK = 24  # vectors' worth of a walk: 600 ticks
LOW, HIGH = -(1 << 30), (1 << 30) - 1


class Overflow(ArithmeticError):
    """A value that a 32-bit MicroPython would put on the heap, or a float."""


class Watch:
    """The largest size of any value since it was last reset."""

    def __init__(self) -> None:
        self.largest = 0


WATCH = Watch()
LITERALS: dict[str, set[int]] = {}  # by module: the integers in its source, worked out where they are sums or products


class Checked(int):
    """An integer whose every result is checked; -2^30 counts as 2^30 - 1, because it is as small."""

    __slots__ = ()

    def __truediv__(self, other: object) -> "Checked":
        raise Overflow(f"{int(self)} / {other}: a float")

    __rtruediv__ = __truediv__

    def __neg__(self) -> "Checked":
        return check(-int(self))

    def __invert__(self) -> "Checked":
        return check(~int(self))

    def __abs__(self) -> "Checked":
        return check(abs(int(self)))


def check(value: object) -> Checked:
    """Return ``value`` as Checked and remember its size; Overflow if it is no small integer."""
    if type(value) is not int and not isinstance(value, bool | Checked):
        raise Overflow(f"{value!r}: a {type(value).__name__} where an integer is wanted")
    return _small(int(value))


def _small(number: int) -> Checked:
    """Return a plain integer as Checked; most of the time of a check is spent here."""
    if not -WATCH.largest <= number <= WATCH.largest:
        if not LOW <= number <= HIGH:
            raise Overflow(f"{number} is outside -2^30 .. 2^30-1")
        WATCH.largest = number if number >= 0 else -number - (number == LOW)
    return Checked(number)


def _operator(name: str) -> Callable[[Checked, object], Checked]:
    plain = getattr(int, name)
    shift, swapped = "shift" in name, name.startswith("__r") and name != "__rshift__"

    def operate(self: Checked, other: object) -> Checked:
        if not isinstance(other, int):
            if isinstance(other, list | tuple | str):
                return NotImplemented  # [0] * n, at set-up
            raise Overflow(f"{int(self)} {name} {other!r}: a {type(other).__name__}")
        if shift and not 0 <= (self if swapped else other) < 32:
            raise Overflow(f"{name} by {int(self if swapped else other)}: a processor shifts by 0 .. 31")
        return _small(plain(self, other))

    return operate


for _name in ("add", "sub", "mul", "floordiv", "mod", "pow", "lshift", "rshift", "and", "or", "xor"):
    setattr(Checked, f"__{_name}__", _operator(f"__{_name}__"))
    setattr(Checked, f"__r{_name}__", _operator(f"__r{_name}__"))


class CheckedArray(plain_array.array):  # type: ignore[type-arg]
    """An array that hands out Checked and takes only small integers."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            raise Overflow("a slice of an array: an allocation")
        if index < 0:
            raise Overflow(f"index {int(index)}: a pointer reads before the array")
        return _small(plain_array.array.__getitem__(self, index))

    def __setitem__(self, index: Any, value: Any) -> None:
        if index < 0:
            raise Overflow(f"index {int(index)}: a pointer writes before the array")
        plain_array.array.__setitem__(self, index, int(check(value)))

    def __iter__(self) -> Iterator[Any]:
        return (self[index] for index in builtins.range(len(self)))


def _zeros(size: int) -> CheckedArray:
    return CheckedArray("i", [0] * size)


def _table(values: tuple[int, ...]) -> CheckedArray:
    return CheckedArray("H", values)


def _words(values: tuple[int, ...]) -> CheckedArray:
    return CheckedArray("i", values)


def _make(field: Any) -> Any:
    """Return what a record holds under a name at first (shared/record.py), checked."""
    if field.of:
        return field.of() if field.count is None else [field.of() for _ in builtins.range(field.count)]
    return check(field.default) if field.count is None else CheckedArray("i", [field.default] * field.count)


def _next(left: list[int]) -> Checked:
    """Return the next of the integers that are unpacked into a record, checked."""
    if not left:
        raise ValueError("integers are missing")
    return check(left.pop())


def _set(values: object, name: str, value: object) -> None:
    """Write a field of a record by its number, checked."""
    setattr(values, name, check(value) if type(value) is int else value)


def _range(*bounds: int) -> Iterator[Checked]:
    return (_small(index) for index in builtins.range(*bounds))


def _integer(value: object) -> Checked:
    return check(value)


class _Literals(ast.NodeTransformer):
    """Replaces the integer literals of function bodies by Checked ones; a float literal is an error."""

    def __init__(self, path: str) -> None:
        self.path = path

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, float | complex):
            raise Overflow(f"{self.path}:{node.lineno}: {node.value!r}: a float")
        if type(node.value) is int:
            return ast.copy_location(ast.Call(ast.Name("_checked", ast.Load()), [node], []), node)
        return node


def literals(tree: ast.AST) -> set[int]:
    """Return every integer a source names, also as an expression of literals such as 3 << 8."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant | ast.BinOp | ast.UnaryOp):
            leaves = [leaf for leaf in ast.walk(node) if isinstance(leaf, ast.expr)]
            if all(isinstance(leaf, ast.Constant | ast.BinOp | ast.UnaryOp) for leaf in leaves):
                try:
                    value = eval(compile(ast.Expression(node), "literal", "eval"), {"__builtins__": {}})
                except (TypeError, ArithmeticError, ValueError):
                    continue
                if type(value) is int and LOW <= value <= HIGH:
                    found.add(value)
    return found


def seams(module: str, low: int, high: int) -> list[int]:
    """Return the values within low .. high at which a mistake can hide: ends, powers of two, what the source names."""
    marks = {low, high, *(1 << bit for bit in range(31)), *LITERALS.get(module, ())}
    near = {sign * mark + off for mark in marks for sign in (1, -1) for off in range(-2, 3)}
    return sorted(value for value in near if low <= value <= high)


class _Loader(importlib.machinery.SourceFileLoader):
    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> Any:  # type: ignore[override]
        tree = ast.parse(data)
        LITERALS[self.name] = literals(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                node.body = [_Literals(str(path)).visit(statement) for statement in node.body]
        return compile(ast.fix_missing_locations(tree), path, "exec")

    def exec_module(self, module: ModuleType) -> None:
        module.__dict__.update(_checked=_small, range=_range, int=_integer)
        super().exec_module(module)
        if module.__name__ == "shared.runtime":
            module.__dict__.update(zeros=_zeros, table=_table, words=_words)
        if module.__name__ == "shared.record":
            module.__dict__.update(_next=_next, setattr=_set)
            module.__dict__["Field"].make = _make


class _Finder(importlib.abc.MetaPathFinder):
    """Loads shared and everything below it with the loader above."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        if name.partition(".")[0] != "shared":
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.origin is not None:
            spec.loader = _Loader(name, spec.origin)
            spec.cached = None
        return spec


def install() -> None:
    """From now on, whatever is imported from ``shared`` is checked, and every array hands out Checked."""
    sys.dont_write_bytecode = True
    fake = ModuleType("array")
    fake.array = CheckedArray  # type: ignore[attr-defined]
    sys.modules["array"] = fake
    sys.meta_path.insert(0, _Finder())


def measure(probe: Any, count: int) -> dict[str, Any]:
    """Return the largest value met in ``count`` vectors of one function, or the error that stopped it."""
    probe.wrap = Checked
    probe.start()
    largest = 0
    for _ in _vectors(probe, count):
        inputs = repr(probe.values)[:300]
        WATCH.largest = 0
        try:
            result = probe.call()
            if probe.ticks and result is not None:
                check(result)
        except (Overflow, ArithmeticError, LookupError, TypeError) as error:
            sentence = f"inputs {inputs}: {type(error).__name__}: {error}"
            return {"name": probe.name, "largest": largest, "error": sentence}
        largest = max(largest, WATCH.largest)
    return {"name": probe.name, "largest": largest, "error": None}


def _vectors(probe: Any, count: int) -> Iterator[None]:
    """Draw the usual vectors into the probe, then every seam, but where a life of states comes before each vector."""
    for index in range(count):
        probe.draw(index, count)
        yield
    if probe.begin is not None:
        return
    kept = probe.arguments
    for at, spread in enumerate(kept):
        if hasattr(spread, "edges"):
            probe.arguments = (*kept[:at], None, *kept[at + 1 :])
            for value in seams(probe.function.__module__, spread.low, spread.high):
                probe.values[at] = value
                probe.draw(count, count)
                yield
    probe.arguments = kept


def answer(module: str, count: int) -> None:
    """Print one marked line of JSON for a module's probes; meant for a process of its own."""
    import json

    install()
    probes = __import__(f"probe.{module}", None, None, ["PROBES"]).PROBES
    rows = [measure(probe, probe.count(min(count, WALK) if hasattr(probe, "length") else count)) for probe in probes]
    print("@@" + json.dumps({"rows": rows}))
