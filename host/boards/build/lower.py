"""Records become arrays: ``trot.weight`` becomes ``_trot[0]`` behind an alias made at the head of the function.

What the other steps of the build read (rules, viper, C) has arrays and indices only. Lines stay where they are. A
record is read and written through a parameter or a local name; handed on, it goes as it is.
"""

import ast
from dataclasses import replace
from pathlib import Path

from .kinds import TABLES, WHOLE, Kinds, Value, block_kinds
from .records import Layout, records_of
from .rewrite import Edit, Places, apply_edits, beside, without_result
from .rules import MARKS
from .source import PACKAGES, Module, called, constant_value, read_modules, refresh

# What reads each in a hot function
_POINTERS = {"record": "ptr32", "array": "ptr32", "table": "ptr16", "words": "ptr32"}


def lowered_modules(root: Path, packages: tuple[str, ...] = PACKAGES) -> dict[str, Module]:
    """Return the modules of ``packages`` under ``root`` by name, without records. BuildError with file and line."""
    return lower(read_modules(root, packages))


def lower(modules: dict[str, Module]) -> dict[str, Module]:
    """Return the modules with arrays in the place of records. BuildError names file, line and what is wrong."""
    kinds = Kinds(modules)
    fields = kinds.layouts.names()
    kinds.exchanged |= {pair for module in modules.values() for pair in _exchanged(module, kinds)}
    return refresh({name: _lowered(module, kinds, fields) for name, module in modules.items()})


def _lowered(module: Module, kinds: Kinds, fields: set[str]) -> Module:
    place = Places(module.text)
    edits: list[Edit] = []
    declared = records_of(module.tree)
    for node in declared:
        layout = kinds.layouts.find(module, node.name)
        assert layout is not None
        edits.append(place.statement(node, _constructor(layout)))
    edits += _imports(module, bool(declared), place)
    edits += Lowering(module, kinds, fields, place).module_level()
    for function, owner in _functions(module):
        edits += Lowering(module, kinds, fields, place).function(function, owner, function in module.hot_functions)
    text = apply_edits(module.text, edits)
    blocks = {f.name: block_kinds(kinds.parameters(module, f, None)) for f in module.hot_functions}
    holders = {f"{module.name}.{node.name}": block_kinds(kinds.members((module.name, node.name)))
               for node in module.tree.body if isinstance(node, ast.ClassDef) and node not in declared}
    tree = ast.parse(text, module.path)
    return Module(module.name, module.path, text, tree, module.is_package, blocks=blocks, holders=holders)


def _exchanged(module: Module, kinds: Kinds) -> set[tuple[tuple[str, str] | None, str]]:
    """Return the attributes, with their classes, that the hot functions of a module give to another object."""
    found = set()
    for function in module.hot_functions:
        lowering = Lowering(module, kinds, set(), Places(module.text))
        lowering.known(function)
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                owner = lowering.resolve(node.value)
                if owner is not None and owner.kind == "object":
                    found.add((owner.owner, node.attr))
    return found


def _functions(module: Module) -> list[tuple[ast.FunctionDef, tuple[str, str] | None]]:
    found: list[tuple[ast.FunctionDef, tuple[str, str] | None]] = []
    for node in module.tree.body:
        if isinstance(node, ast.FunctionDef):
            found.append((node, None))
        elif isinstance(node, ast.ClassDef):
            found += [(inner, (module.name, node.name)) for inner in node.body if isinstance(inner, ast.FunctionDef)]
    return found


def _constructor(layout: Layout) -> str:
    """Return what a record's class becomes: a function that makes its array."""
    given = [(at, value) for at, value in enumerate(layout.defaults()) if value]
    values = f", ({''.join(f'{pair}, ' for pair in given)})" if given else ""
    return f"def {layout.name}(): return block({layout.size}{values})"


def _imports(module: Module, declares: bool, place: Places) -> list[Edit]:
    """What only declares records is not imported: ``Axes``, ``Ints`` and the kinds of fields."""
    edits = []
    for node in module.tree.body:
        if not isinstance(node, ast.ImportFrom) or (node.module or "").split(".")[-1] not in ("record", "runtime"):
            continue
        gone = ("Axes", "Ints", "field", "vector", "part", "parts", "record")
        names = [name.name for name in node.names if name.name not in gone]
        if (node.module or "").endswith("record") and declares:
            names.append("block")
        if len(names) != len(node.names) or "block" in names:
            source = "." * node.level + (node.module or "")
            edits.append(place.statement(node, f"from {source} import {', '.join(names)}" if names else "pass"))
    return edits


class Lowering:
    """The edits of one function, or of what stands at a module's level."""

    def __init__(self, module: Module, kinds: Kinds, fields: set[str], place: Places) -> None:
        self.module, self.kinds, self.fields, self.place = module, kinds, fields, place
        self.names: dict[str, Value] = dict(kinds.globals_of(module))
        self.hot = False
        self._heads: dict[str, tuple[str, str]] = {}  # aliases to be made at the function's head: kind and what of
        self._given: set[str] = set()

    def module_level(self) -> list[Edit]:
        """Return the edits of the statements outside functions and classes."""
        statements = [node for node in self.module.tree.body if not isinstance(node, ast.FunctionDef | ast.ClassDef)]
        return [edit for node in statements for edit in self._edits(node)]

    def function(self, function: ast.FunctionDef, owner: tuple[str, str] | None, hot: bool) -> list[Edit]:
        """Return the edits of a function; ``owner``: the class it is a method of."""
        self.hot = hot
        self._enter(function, owner)
        edits = [edit for statement in function.body for edit in self._edits(statement)]
        for argument in function.args.args:
            if argument.arg in self._given and argument.annotation is not None:
                start = self.place.start(argument) + len(argument.arg)
                edits.append(Edit(start, self.place.end(argument.annotation) - start, ""))
        if not hot and function.returns is not None:
            edits.append(without_result(self.module, function, self.place))
        if self._heads:
            head = "; ".join(f"{alias} = {kind}({name})" for alias, (kind, name) in self._heads.items())
            edits.append(beside(self.module, function, head, self.place))
        return edits

    def known(self, function: ast.FunctionDef) -> dict[str, Value]:
        """Return what the parameters and local names of a hot function that are more than a number stand for."""
        self._enter(function, None)
        return self.names

    def _enter(self, function: ast.FunctionDef, owner: tuple[str, str] | None) -> None:
        """Learn what a function's parameters and local names stand for."""
        for argument in function.args.args:
            self.names.pop(argument.arg, None)
        given = self.kinds.parameters(self.module, function, owner)
        self.names |= given
        self._given = set(given)
        self._assignments(function)

    # what local names stand for

    def _assignments(self, function: ast.FunctionDef) -> None:
        """Learn, in order, what is kept under local names."""
        statements = [node for node in ast.walk(function) if isinstance(node, ast.Assign | ast.AnnAssign)]
        for node in sorted(statements, key=lambda one: one.lineno):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            if not isinstance(target, ast.Name):
                continue
            if isinstance(node, ast.Assign):
                self._assign(node, target.id)
            elif value := self.kinds.annotated(self.module, node.annotation, target.id):
                self.names[target.id] = value

    def _assign(self, node: ast.Assign, name: str) -> None:
        value, known = self._local(name, node.value), self.names.get(name)
        if value is None:
            if name not in self._given and called(node.value) not in MARKS:
                self.names.pop(name, None)
            return
        if known is not None and known.kind == value.kind == "record" and known.raw != value.raw:
            raise self.module.error(node, f"{name} stands for {known.raw} already: one name for one record")
        self.names[name] = value

    def _local(self, name: str, node: ast.expr) -> Value | None:
        found = self.resolve(node)
        if found is None:
            made = isinstance(node, ast.Call | ast.List | ast.ListComp) and not self.hot
            return self.kinds.made(self.module, node, name, self.resolve) if made else None
        if found.kind in ("within", "run"):
            return replace(found, at=name)
        if self.hot and found.kind in _POINTERS:
            return replace(found, text=name)
        if self.hot and found.kind == "object":
            return found
        if found.kind in WHOLE:
            return found.named(name)
        return None

    # expressions

    def resolve(self, node: ast.expr) -> Value | None:
        """Return what an expression of names, attributes and elements stands for; None if nothing is known of it."""
        if isinstance(node, ast.Name):
            return self.names.get(node.id)
        if isinstance(node, ast.Attribute):
            return self._attribute(node)
        if isinstance(node, ast.Subscript):
            return self._element(node)
        return None

    def _attribute(self, node: ast.Attribute) -> Value | None:
        if self._is_module(node.value):
            assert isinstance(node.value, ast.Name)
            origin = self.kinds.modules[self.module.aliases[node.value.id]]
            found = self.kinds.globals_of(origin).get(node.attr)
            return found.named(f"{node.value.id}.{node.attr}") if found else None
        base = self.resolve(node.value)
        if base is None:
            if node.attr in self.fields and (self.hot or node.attr not in self.kinds.attributes):
                what = ast.unparse(node.value)
                raise self.module.error(node, f"what is {what}? .{node.attr} is a field of a record: annotate {what}")
            return None
        if base.kind in ("record", "within"):
            assert base.layout is not None
            place = base.layout.places.get(node.attr)
            if place is None:
                raise self.module.error(node, f"{base.layout.name} has no field {node.attr}")
            at = _sum(base.at, str(place.at))
            if place.count is None and place.of is None:
                return Value("number", self._root(base, node), at=at)
            kind = "within" if place.count is None else "run"
            return Value(kind, self._root(base, node), place.of, at, raw=base.raw)
        return self.kinds.attribute(base, node.attr)

    def _element(self, node: ast.Subscript) -> Value | None:
        base = self.resolve(node.value)
        if base is None or isinstance(node.slice, ast.Slice):
            return None
        if base.kind == "list":
            assert base.inner is not None
            return base.inner.named(f"{base.text}[{self._text(node.slice)}]")
        if base.kind == "run":
            size = base.layout.size if base.layout else 1
            at = _sum(base.at, self._times(node.slice, size))
            return Value("within" if base.layout else "number", base.text, base.layout, at, raw=base.raw)
        if base.kind in ("record", "within") and base.layout is not None and base.layout.numbered:
            return Value("number", self._root(base, node), at=_sum(base.at, self._times(node.slice, 1)))
        if base.kind in ("array", *TABLES):
            if not self.hot:
                return None  # an array's element needs no change
            return Value("number", self._root(base, node), at=self._text(node.slice))
        return None

    def _root(self, base: Value, node: ast.expr) -> str:
        """Return the name of the array; in hot functions that of its alias."""
        if not self.hot or base.kind in ("within",):
            return base.text
        if base.text.isidentifier() and not (base.text in self._given and base.text == base.raw):
            return base.text
        first, *rest = base.text.split(".")
        if first not in self._given or not all(name.isidentifier() for name in rest):
            raise self.module.error(node, f"{base.text} is read through a name: give it one first")
        owner = self.names[first]
        for name in rest:
            if (owner.owner, name) in self.kinds.exchanged:
                raise self.module.error(node, f"{base.text} may be another one later: give it a name first")
            owner = self.kinds.attribute(owner, name) or owner
        alias = f"_{base.text.replace('.', '_')}"
        self._heads[alias] = (_POINTERS[base.kind], base.text)
        return alias

    def _times(self, index: ast.expr, size: int) -> str:
        value = constant_value(index, self.module.constants)
        if value is not None:
            return str(value * size)
        text = self._text(index)
        if isinstance(index, ast.BinOp) and isinstance(index.op, ast.Add) and size == 1:
            return _with_number(text, index.right, constant_value(index.right, self.module.constants))
        if not isinstance(index, ast.Name):
            text = f"({text})"
        return text if size == 1 else f"{text} * {size}"

    def _is_module(self, node: ast.expr) -> bool:
        return isinstance(node, ast.Name) and node.id in self.module.aliases and node.id not in self.names

    # edits

    def _text(self, node: ast.expr) -> str:
        """Return the source of an expression with its own edits made."""
        start, end = self.place.start(node), self.place.end(node)
        edits = [replace(edit, offset=edit.offset - start) for edit in self._edits(node)]
        return apply_edits(self.module.text[start:end], edits).decode()

    def _edits(self, node: ast.AST) -> list[Edit]:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            edit = self._kept(node)
            if edit is not None:
                return [edit]
        if called(node) in MARKS:
            return []  # an alias made by hand
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not self._is_module(node.func.value):
            return [edit for part in (node.func.value, *node.args, *node.keywords) for edit in self._edits(part)]
        if isinstance(node, ast.Attribute | ast.Subscript | ast.Name):
            found = self.resolve(node)
            if found is not None and (changed := self._changed(node, found)) is not None:
                return [self.place.edit(node, changed)]
        return [edit for child in ast.iter_child_nodes(node) for edit in self._edits(child)]

    def _kept(self, node: ast.Assign) -> Edit | None:
        """The edit of ``name = a record, a part of one or an object``."""
        found = self.resolve(node.value)
        if found is not None and found.kind in ("within", "run"):
            return self.place.edit(node.value, found.at)
        if found is not None and self.hot and found.kind in _POINTERS:
            return self.place.edit(node.value, f"{_POINTERS[found.kind]}({found.raw})")
        if found is not None and self.hot and found.kind == "object":
            return self.place.edit(node, "pass")
        return None

    def _changed(self, node: ast.expr, found: Value) -> str | None:
        """Return the new text of an expression; None: as it is."""
        if found.kind == "number":
            return f"{found.text}[{found.at}]"
        if found.kind in ("within", "run"):
            raise self.module.error(node, f"{ast.unparse(node)} is a part of a block: hand on the block and an index")
        if isinstance(node, ast.Name):
            store = isinstance(node.ctx, ast.Store)
            return None if store or found.raw in ("", node.id) else found.raw
        return found.raw if found.raw and found.raw != ast.unparse(node) else None


def _sum(left: str, right: str) -> str:
    """Return two expressions added; numbers are."""
    if left == "0" or right == "0":
        return right if left == "0" else left
    if left.isdigit() and right.isdigit():
        return str(int(left) + int(right))
    head, _, tail = left.rpartition(" + ")
    if head and tail.isdigit() and right.isdigit():
        return f"{head} + {int(tail) + int(right)}"
    head, _, tail = left.partition(" + ")
    if head.isdigit() and tail and right.isdigit():
        return f"{int(head) + int(right)} + {tail}"
    head, _, tail = right.rpartition(" + ")
    if head and tail.isdigit() and left.isdigit():
        return f"{head} + {int(tail) + int(left)}"
    return f"{left} + {right}"


def _with_number(text: str, right: ast.expr, value: int | None) -> str:
    """Return a sum with the number in the place of the constant at its end, if there is one."""
    name = ast.unparse(right)
    return f"{text.removesuffix(name)}{value}" if value is not None and text.endswith(f" {name}") else text
