"""What a name or an expression stands for, as far as the build must know: records, arrays, objects that hold them."""

import ast
from collections.abc import Callable
from dataclasses import dataclass, replace

from .records import Layout, Layouts
from .source import Module, resolve

TABLES = ("table", "words")  # numbers that never change, of 16 bits and of 32: kinds as the marks that make them
WHOLE = ("array", *TABLES, "record", "object", "list")  # kinds that have a name of their own


@dataclass(frozen=True)
class Value:
    """``text`` names it in the lowered source; a field is in the array ``text`` at ``at``, an expression.

    kind: "number", "array", "table" (of halfwords), "words" (a table of them), "record" (a whole one), "within" (a
    record in another), "run" (a vector or a list of records within one), "object" (of ``owner``, a class), "list" (of
    ``inner``).
    """

    kind: str
    text: str
    layout: Layout | None = None
    at: str = "0"
    owner: tuple[str, str] | None = None
    inner: "Value | None" = None
    raw: str = ""  # what to hand on, where ``text`` is a pointer

    def named(self, text: str) -> "Value":
        """Return the same under another name."""
        return replace(self, text=text, raw=text)


def block_kinds(values: dict[str, Value]) -> dict[str, str]:
    """Return of what is known which are an "array", or by the dotted name of its class an object that holds some."""
    found = {name: "array" for name, value in values.items() if value.kind in ("array", "record")}
    return found | {name: ".".join(value.owner) for name, value in values.items() if value.owner}


def _attributes(tree: ast.AST) -> set[str]:
    """Return the attributes that a class sets up for its objects, or all classes of a module for theirs."""
    return {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)
            and isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name) and node.value.id == "self"}


class Kinds:
    """Finds them through annotations, constructors and the attributes that classes set up; imports nothing."""

    def __init__(self, modules: dict[str, Module]) -> None:
        self.modules = modules
        self.layouts = Layouts(modules)
        self.attributes = {name for module in modules.values() for name in _attributes(module.tree)}
        self.exchanged: set[tuple[tuple[str, str] | None, str]] = set()  # attributes that hot functions set, by class
        self._globals: dict[str, dict[str, Value]] = {}
        self._classes: dict[tuple[str, str], dict[str, Value]] = {}

    def annotated(self, module: Module, node: ast.expr | None, text: str) -> Value | None:
        """Return what an annotation says that ``text`` is; None if it is nothing of these."""
        if isinstance(node, ast.Name):
            if node.id == "Ints":
                return Value("array", text, raw=text)
            layout = self.layouts.find(module, node.id)
            if layout:
                return Value("record", text, layout, raw=text)
            owner = self._class(module, node.id)
            return Value("object", text, owner=owner, raw=text) if owner else None
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id == "list":
            inner = self.annotated(module, node.slice, "")
            return Value("list", text, inner=inner, raw=text) if inner else None
        return None

    def made(
        self, module: Module, node: ast.expr, text: str, known: Callable[[ast.expr], Value | None]
    ) -> Value | None:
        """Return what the value ``node`` makes of ``text``; ``known`` tells of names and attributes."""
        if isinstance(node, ast.Call):
            return self._called(module, node, text)
        if isinstance(node, ast.ListComp) or (isinstance(node, ast.List | ast.Tuple) and node.elts):
            element = node.elt if isinstance(node, ast.ListComp) else node.elts[0]
            inner = self.made(module, element, "", known)
            return Value("list", text, inner=inner, raw=text) if inner else None
        found = known(node)
        return found.named(text) if found and found.kind in WHOLE else None

    def _called(self, module: Module, call: ast.Call, text: str) -> Value | None:
        at = self._function(module, call.func)
        if at is None:
            return None
        origin, name = at
        if name in ("zeros", *TABLES):
            return Value("array" if name == "zeros" else name, text, raw=text)
        found = self.annotated(origin, ast.Name(name), text)
        if found is not None:
            return found
        target = resolve(origin, name, self.modules)
        for node in target[0].tree.body if target else []:
            if isinstance(node, ast.FunctionDef) and target is not None and node.name == target[1]:
                return self.annotated(target[0], node.returns, text)
        return None

    def _function(self, module: Module, node: ast.expr) -> tuple[Module, str] | None:
        if isinstance(node, ast.Name):
            return module, node.id
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            origin = module.aliases.get(node.value.id)
            return (self.modules[origin], node.attr) if origin else None
        return None

    def globals_of(self, module: Module) -> dict[str, Value]:
        """Return what a module's own names stand for, and those it imports."""
        if module.name not in self._globals:
            self._globals[module.name] = found = {}
            for name in module.imports:
                target = resolve(module, name, self.modules)
                value = self.globals_of(target[0]).get(target[1]) if target and target[0] is not module else None
                if value is not None:
                    found[name] = value.named(name)
            for node in module.tree.body:
                self._take(module, node, found)
        return self._globals[module.name]

    def _take(self, module: Module, node: ast.stmt, found: dict[str, Value]) -> None:
        """Take in what an assignment at a module's level makes."""
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name, value = node.target.id, self.annotated(module, node.annotation, node.target.id)
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            value = self.made(module, node.value, name, lambda e: self._plain(module, e, found))
        else:
            return
        if value is not None:
            found[name] = value

    def _plain(self, module: Module, node: ast.expr, names: dict[str, Value]) -> Value | None:
        """Return what a name, or a chain of attributes of objects, stands for."""
        if isinstance(node, ast.Name):
            return names.get(node.id)
        if isinstance(node, ast.Attribute):
            if isinstance(node.value, ast.Name) and node.value.id in module.aliases:
                return self.globals_of(self.modules[module.aliases[node.value.id]]).get(node.attr)
            base = self._plain(module, node.value, names)
            return self.attribute(base, node.attr) if base else None
        if isinstance(node, ast.Subscript):
            base = self._plain(module, node.value, names)
            return base.inner if base and base.kind == "list" else None
        return None

    def attribute(self, base: Value, name: str) -> Value | None:
        """Return what attribute ``name`` of an object is; its text is the base's with the name behind."""
        if base.owner is None:
            return None
        value = self.members(base.owner).get(name)
        return value.named(f"{base.raw or base.text}.{name}") if value else None

    def _class(self, module: Module, name: str) -> tuple[str, str] | None:
        """Return the class that ``name`` is; where it sets up nothing of its own, the one that it is derived from."""
        found = resolve(module, name, self.modules)
        for node in found[0].tree.body if found else ():
            if isinstance(node, ast.ClassDef) and found is not None and node.name == found[1]:
                base = node.bases[0] if node.bases and not _attributes(node) else None
                above = self._class(found[0], base.id) if isinstance(base, ast.Name) else None
                return above or (found[0].name, node.name)
        return None

    def members(self, owner: tuple[str, str]) -> dict[str, Value]:
        """Return the attributes that are known of a class, by name."""
        if owner not in self._classes:
            self._classes[owner] = found = {}
            module = self.modules[owner[0]]
            declared = next(n for n in module.tree.body if isinstance(n, ast.ClassDef) and n.name == owner[1])
            for base in declared.bases:
                above = self._class(module, base.id) if isinstance(base, ast.Name) else None
                found.update(self.members(above) if above else {})
            for node in declared.body:
                if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                    _keep(found, node.target.id, self.annotated(module, node.annotation, ""))
            for method in (n for n in declared.body if isinstance(n, ast.FunctionDef)):
                self._assigned(module, owner, method, found)
        return self._classes[owner]

    def _assigned(
        self, module: Module, owner: tuple[str, str], method: ast.FunctionDef, found: dict[str, Value]
    ) -> None:
        names = dict(self.globals_of(module)) | self.parameters(module, method, owner)
        for node in ast.walk(method):
            target = node.targets[0] if isinstance(node, ast.Assign) else None
            if isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name) and target.value.id == "self":
                value = self.made(module, node.value, "", lambda e: self._plain(module, e, names))  # type: ignore[attr-defined]
                _keep(found, target.attr, value)

    def parameters(self, module: Module, function: ast.FunctionDef, owner: tuple[str, str] | None) -> dict[str, Value]:
        """Return what a function's parameters stand for; ``owner``: the class it is a method of."""
        found = {}
        for at, given in enumerate(function.args.args):
            value = self.annotated(module, given.annotation, given.arg)
            if at == 0 and owner and given.arg == "self":
                value = Value("object", "self", owner=owner, raw="self")
            if value:
                found[given.arg] = value
        return found


def _keep(found: dict[str, Value], name: str, value: Value | None) -> None:
    if value is not None:
        found.setdefault(name, value)
