"""The sources a build reads: modules by name, their imports, their constants and their hot functions.

Everything is read from the syntax tree, nothing is imported, so a broken module cannot run here.
"""

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

PACKAGES = ("shared", "firmware")
# A board has the folders as a checkout has them; installed on a computer they lie below `caramelo` (setup.py).
_BELOW = re.compile(rb"(?m)^(\s*from )caramelo\.(?=(?:shared|firmware|host)\b)")


class BuildError(Exception):
    """A source that cannot be built; the text is ``file:line: what is wrong``."""


@dataclass
class Module:
    """One source file: ``name`` is dotted, ``path`` relative to the root with forward slashes."""

    name: str
    path: str
    text: bytes
    tree: ast.Module
    is_package: bool
    constants: dict[str, int] = field(default_factory=dict)
    imports: dict[str, tuple[str, str]] = field(default_factory=dict)  # local name -> (module, name)
    aliases: dict[str, str] = field(default_factory=dict)  # local name -> the module it stands for
    needs: set[str] = field(default_factory=set)  # modules it imports, dotted
    # what lowering knew of the parameters of hot functions, and of the attributes of the classes that hold blocks:
    # "array", or the dotted name of such a class
    blocks: dict[str, dict[str, str]] = field(default_factory=dict)
    holders: dict[str, dict[str, str]] = field(default_factory=dict)

    @cached_property
    def hot_functions(self) -> list[ast.FunctionDef]:
        """The functions marked ``@hot``, in order."""
        return [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, ast.FunctionDef) and any(is_name(mark, "hot") for mark in node.decorator_list)
        ]

    @cached_property
    def hot(self) -> dict[str, ast.FunctionDef]:
        """The same by name."""
        return {function.name: function for function in self.hot_functions}

    def error(self, node: ast.AST, sentence: str) -> BuildError:
        return BuildError(f"{self.path}:{getattr(node, 'lineno', 1)}: {sentence}")


def read_modules(root: Path, packages: tuple[str, ...] = PACKAGES) -> dict[str, Module]:
    """Return every module of ``packages`` under ``root`` by dotted name, with names resolved."""
    modules: dict[str, Module] = {}
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            module = _read(root, path)
            modules[module.name] = module
    return refresh(modules)


def refresh(modules: dict[str, Module]) -> dict[str, Module]:
    """Find every module's imports and constants, and return them."""
    for module in modules.values():
        find_imports(module, modules)
    for module in modules.values():
        _find_constants(module, modules, ())
    return modules


def has_no_result(function: ast.FunctionDef) -> bool:
    """Return whether a hot function is annotated ``-> None``."""
    return isinstance(function.returns, ast.Constant) and function.returns.value is None


def closure(modules: dict[str, Module], seeds: list[str]) -> list[str]:
    """Return ``seeds`` and everything they import, with the packages that hold them, sorted."""
    found: set[str] = set()
    waiting = list(seeds)
    while waiting:
        name = waiting.pop()
        if name in found or name not in modules:
            continue
        found.add(name)
        waiting += modules[name].needs
        if "." in name:
            waiting.append(name.rpartition(".")[0])
    return sorted(found)


def resolve(module: Module, name: str, modules: dict[str, Module]) -> tuple[Module, str] | None:
    """Return the module and the name under which ``name`` is defined; None if it is not in the sources."""
    seen = set()
    while name in module.imports and (module.name, name) not in seen:
        seen.add((module.name, name))
        origin, name = module.imports[name]
        if origin not in modules:
            return None
        module = modules[origin]
    return module, name


def _read(root: Path, path: Path) -> Module:
    relative = path.relative_to(root).as_posix()
    text = _BELOW.sub(rb"\1", path.read_bytes())
    try:
        tree = ast.parse(text, relative)
    except SyntaxError as error:
        raise BuildError(f"{relative}:{error.lineno}: {error.msg}") from error
    dotted = relative.removesuffix(".py").replace("/", ".")
    return Module(dotted.removesuffix(".__init__"), relative, text, tree, path.name == "__init__.py")


def is_name(node: ast.AST | None, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def called(node: ast.AST | None) -> str:
    """Return the name that ``node`` calls; "" if it is no call, or one of something without a name."""
    return node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""


def calls(node: ast.AST) -> Iterator[tuple[str, ast.Call]]:
    """Yield every call of a name in ``node`` behind that name."""
    for inner in ast.walk(node):
        if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name):
            yield inner.func.id, inner


def assignments(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, ast.expr]]:
    """Yield name and value of each ``name = value`` among ``nodes``."""
    for node in nodes:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            yield node.targets[0].id, node.value


def stored_names(function: ast.FunctionDef) -> set[str]:
    """Return the names that a function sets; its parameters only if it sets them anew."""
    return {node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def find_imports(module: Module, modules: dict[str, Module]) -> None:
    """Fill ``module.imports`` and ``module.needs`` from its tree."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            module.needs |= {alias.name for alias in node.names if alias.name in modules}
        elif isinstance(node, ast.ImportFrom):
            origin = _origin(module, node)
            for alias in node.names:
                inner = f"{origin}.{alias.name}"
                module.needs.add(inner if inner in modules else origin)
                if inner in modules:
                    module.aliases[alias.asname or alias.name] = inner
                if origin in modules and inner not in modules:
                    module.imports[alias.asname or alias.name] = (origin, alias.name)
    module.needs &= set(modules)


def _origin(module: Module, node: ast.ImportFrom) -> str:
    """Return the dotted name of the module that ``from ... import`` reads."""
    if not node.level:
        return node.module or ""
    parts = module.name.split(".")
    if not module.is_package:
        parts.pop()
    parts = parts[: len(parts) - (node.level - 1)]
    return ".".join([*parts, node.module] if node.module else parts)


def _find_constants(module: Module, modules: dict[str, Module], chain: tuple[str, ...]) -> None:
    """Fill ``module.constants`` with every ``NAME = const(...)`` of the module and of its imports."""
    if module.constants or module.name in chain:
        return
    for name, (origin, original) in module.imports.items():
        _find_constants(modules[origin], modules, (*chain, module.name))
        if original in modules[origin].constants:
            module.constants[name] = modules[origin].constants[original]
    for name, call in assignments(module.tree.body):
        if isinstance(call, ast.Call) and called(call) == "const":
            value = constant_value(call.args[0], module.constants)
            if value is None:
                raise module.error(call, "const() needs an integer that follows from literals and other constants")
            module.constants[name] = value


_OPERATIONS = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.FloorDiv: lambda a, b: a // b,
    ast.Mod: lambda a, b: a % b,
    ast.LShift: lambda a, b: a << b,
    ast.RShift: lambda a, b: a >> b,
    ast.BitAnd: lambda a, b: a & b,
    ast.BitOr: lambda a, b: a | b,
    ast.BitXor: lambda a, b: a ^ b,
    ast.Pow: lambda a, b: a**b,
}


def constant_value(node: ast.AST, names: dict[str, int]) -> int | None:
    """Return the integer an expression of literals and known names stands for; None if it is not one."""
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    if isinstance(node, ast.Name):
        return names.get(node.id)
    if isinstance(node, ast.UnaryOp):
        inner = constant_value(node.operand, names)
        if inner is None:
            return None
        return {ast.USub: -inner, ast.UAdd: inner, ast.Invert: ~inner}.get(type(node.op))  # type: ignore[call-overload]
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        left, right = constant_value(node.left, names), constant_value(node.right, names)
        if left is None or right is None:
            return None
        return int(_OPERATIONS[type(node.op)](left, right))
    return None
