"""A hot function as C: the same integers, the same order of evaluation, statement by statement.

A hot function has numbers, arrays, objects that hold arrays and objects that are handed on, and nothing else
(rules.py), so its C is the Python written with other signs. An array is handed on as the address of its elements, an
object that holds arrays as what is known of it so far (c_holders.py). Numbers are 32 bits and wrap, as in viper; // and
>> round down; a division by zero gives 0, as a Cortex-M does. Where an expression calls something, what is read before
the call is kept first, because C leaves the order of evaluation open and Python does not.
"""

import ast

from .c_holders import ARRAY, accessor, c_type, converted, holder_type
from .rules import aliases, hot_function
from .source import Module, calls, has_no_result, resolve, stored_names

_TYPES = {"ptr8": "uint8_t", "ptr16": "uint16_t", "ptr32": "int32_t", "reg16": "volatile uint16_t",
          "reg32": "volatile int32_t"}
_SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^",
          ast.LShift: "<<", ast.RShift: ">>"}
_COMPARES = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
_DIVISIONS = {ast.FloorDiv: "core_floor", ast.Mod: "core_modulo"}


def c_name(module: str, name: str) -> str:
    """Return the C name of what the module ``module`` calls ``name``."""
    return f"{module.replace('.', '_')}__{name}"


def signature(module: Module, function: ast.FunctionDef) -> str:
    """Return the head of the function in C."""
    blocks = module.blocks.get(function.name, {})
    kinds = [f"{'int32_t ' if p.annotation else c_type(blocks.get(p.arg))}{c_local(p.arg)}" for p in function.args.args]
    result = "void" if has_no_result(function) else "int32_t"
    return f"static {result} {c_name(module.name, function.name)}({', '.join(kinds) or 'void'})"


def c_local(name: str) -> str:
    """Return a local name that is none of C's own."""
    return f"{name}_"


class FunctionWriter:
    """Writes one function; ``tables`` gathers the constant arrays it reads, by C name."""

    def __init__(self, module: Module, function: ast.FunctionDef, modules: dict[str, Module]) -> None:
        self.module = module
        self.function = function
        self.modules = modules
        self.tables: dict[str, tuple[Module, str]] = {}
        self._pointers = aliases(function)
        self._given = {parameter.arg for parameter in function.args.args}
        self._blocks = module.blocks.get(function.name, {})
        stored = stored_names(function)
        self._local = self._given | stored
        self._numbers = sorted(stored - self._given - set(self._pointers))
        self._lines: list[str] = []
        self._depth = 1
        self._count = 0
        self._keep = False

    def write(self) -> str:
        """Return the whole function in C."""
        self._block(self.function.body)
        head = [f"    int32_t {c_local(name)} = 0;" for name in self._numbers]
        head += [f"    {_TYPES[kind]} *{c_local(name)} = 0;" for name, kind in self._pointers.items()]
        return "\n".join([signature(self.module, self.function) + " {", *head, *self._lines, "}"])

    # statements

    def _line(self, text: str) -> None:
        self._lines.append("    " * self._depth + text)

    def _block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, node: ast.stmt) -> None:
        if isinstance(node, ast.Expr):
            if not isinstance(node.value, ast.Constant):
                self._line(f"(void){self._value(node.value)};")
        elif isinstance(node, ast.Assign):
            self._assign(node.targets[0], node.value)
        elif isinstance(node, ast.AugAssign):
            self._augmented(node)
        elif isinstance(node, ast.Return):
            self._line(f"return {self._value(node.value)};" if node.value else "return;")
        elif isinstance(node, ast.If):
            self._if(node)
        elif isinstance(node, ast.While):
            self._while(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Break | ast.Continue | ast.Pass):
            self._line({ast.Break: "break;", ast.Continue: "continue;", ast.Pass: ";"}[type(node)])
        else:
            raise self.module.error(node, f"{type(node).__name__} is not known to the C of a hot function")

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Tuple):
            self._swap(target, value)
        elif isinstance(target, ast.Attribute):
            self._set(target, self._object(value))
        elif isinstance(target, ast.Name) and target.id in self._pointers:
            self._line(f"{c_local(target.id)} = {self._pointer(value)};")
        else:
            text = self._value(value)
            if isinstance(target, ast.Subscript) and _calls(target, self):
                text = self._kept(text)
            self._line(f"{self._place(target)} = {text};")

    def _set(self, target: ast.Attribute, text: str) -> None:
        self._line(f"core_set({self._object(target.value)}, CORE_NAME({target.attr}), {text});")
        if self._attribute_kind(target):
            assert isinstance(target.value, ast.Name)  # an attribute of a parameter
            self._line(f"{c_local(target.value.id)}->{c_local(target.attr)} = 0;")  # read anew

    def _swap(self, target: ast.Tuple, value: ast.expr) -> None:
        assert isinstance(value, ast.Tuple)  # check_hot saw to that
        kept = [self._kept(self._value(element)) for element in value.elts]
        for place, text in zip(target.elts, kept, strict=True):
            self._line(f"{self._place(place)} = {text};")

    def _augmented(self, node: ast.AugAssign) -> None:
        place = self._place(node.target, fix=True)
        held = self._kept(place) if _calls(node.value, self) else place
        self._line(f"{place} = {self._binary(node.op, held, self._value(node.value), node.value)};")

    def _place(self, target: ast.expr, fix: bool = False) -> str:
        if isinstance(target, ast.Name):
            return c_local(target.id)
        assert isinstance(target, ast.Subscript)  # check_hot saw to that
        assert isinstance(target.value, ast.Name)
        index = self._value(target.slice)
        if fix and not isinstance(target.slice, ast.Constant | ast.Name):
            index = self._kept(index)
        return f"{c_local(target.value.id)}[{index}]"

    def _if(self, node: ast.If) -> None:
        self._line(f"if ({self._value(node.test)}) {{")
        self._inner(node.body)
        if node.orelse:
            self._line("} else {")
            self._inner(node.orelse)
        self._line("}")

    def _while(self, node: ast.While) -> None:
        self._line("for (;;) {")
        self._depth += 1
        self._line(f"if (!({self._value(node.test)})) break;")
        self._block(node.body)
        self._depth -= 1
        self._line("}")

    def _for(self, node: ast.For) -> None:
        assert isinstance(node.iter, ast.Call)  # check_hot saw to that
        assert isinstance(node.target, ast.Name)
        texts = [self._kept(self._value(argument)) for argument in node.iter.args]
        start, stop, step = {1: ["0", *texts, "1"], 2: [*texts, "1"], 3: texts}[len(texts)]
        at = self._name()
        down = len(texts) == 3 and ast.unparse(node.iter.args[2]).startswith("-")
        self._line(f"for (int32_t {at} = {start}; {at} {'>' if down else '<'} {stop}; {at} += {step}) {{")
        self._depth += 1
        self._line(f"{c_local(node.target.id)} = {at};")
        self._block(node.body)
        self._depth -= 1
        self._line("}")

    def _inner(self, statements: list[ast.stmt]) -> None:
        self._depth += 1
        self._block(statements)
        self._depth -= 1

    # expressions

    def _value(self, node: ast.expr) -> str:
        """Return the expression in C, after lines that keep what must be evaluated before it."""
        before = self._keep
        self._keep = before or _calls(node, self) > 1 or (_calls(node, self) == 1 and _reads(node) > 0)
        text = self._expression(node)
        self._keep = before
        return text

    def _expression(self, node: ast.expr) -> str:
        if isinstance(node, ast.Constant):
            assert isinstance(node.value, int)  # check_hot saw to that
            return str(int(node.value))
        if isinstance(node, ast.Name):
            return self._read(node)
        if isinstance(node, ast.BinOp):
            left = self._expression(node.left)
            return self._binary(node.op, left, self._expression(node.right), node.right)
        if isinstance(node, ast.UnaryOp):
            sign = {ast.USub: "-", ast.UAdd: "+", ast.Invert: "~", ast.Not: "!"}[type(node.op)]
            return f"({sign}{self._expression(node.operand)})"
        if isinstance(node, ast.Compare):
            return self._compare(node)
        if isinstance(node, ast.BoolOp):
            return self._choice(node)
        if isinstance(node, ast.Subscript):
            return self._temporary(self._place(node))
        if isinstance(node, ast.Call):
            return self._call(node)
        raise self.module.error(node, f"{type(node).__name__} is not known to the C of a hot function")

    def _read(self, node: ast.Name) -> str:
        if node.id in self._local:
            return c_local(node.id)
        value = self.module.constants.get(node.id)
        if value is None:
            raise self.module.error(node, f"{node.id} is neither a local name nor a const")
        return str(value) if value >= 0 else f"({value})"

    def _binary(self, operator: ast.operator, left: str, right: str, node: ast.expr) -> str:
        division = _DIVISIONS.get(type(operator))
        return f"{division}({left}, {right})" if division else f"({left} {_SIGNS[type(operator)]} {right})"

    def _compare(self, node: ast.Compare) -> str:
        terms = [node.left, *node.comparators]
        texts = [self._expression(term) for term in terms]
        if len(terms) > 2:
            texts = [self._kept(text) for text in texts]
        pairs = zip(texts, node.ops, texts[1:], strict=False)
        return "(" + " && ".join(f"{a} {_COMPARES[type(op)]} {b}" for a, op, b in pairs) + ")"

    def _choice(self, node: ast.BoolOp) -> str:
        """``and`` and ``or`` stop as in C; where a later part needs lines of its own, these are put behind an if."""
        both = isinstance(node.op, ast.And)
        if not any(_calls(value, self) for value in node.values[1:]) and not self._keep:
            return "(" + (" && " if both else " || ").join(self._expression(value) for value in node.values) + ")"
        held = self._kept(self._expression(node.values[0]))
        for value in node.values[1:]:
            self._line(f"if ({'' if both else '!'}{held}) {{")
            self._depth += 1
            self._line(f"{held} = {self._value(value)};")
            self._depth -= 1
            self._line("}")
        return held

    def _call(self, node: ast.Call) -> str:
        assert isinstance(node.func, ast.Name)  # check_hot saw to that
        if node.func.id == "int":
            return self._expression(node.args[0])
        if node.func.id in _TYPES:
            raise self.module.error(node, f"{node.func.id}: a pointer gets a name of its own first")
        found = resolve(self.module, node.func.id, self.modules)
        assert found is not None  # check_hot saw to that
        callee, wanted = found[0].hot[found[1]], found[0].blocks.get(found[1], {})
        texts = []
        for argument, parameter in zip(node.args, callee.args.args, strict=True):
            kind = wanted.get(parameter.arg)
            texts.append(self._expression(argument) if parameter.annotation else self._handed(argument, kind))
        text = f"{c_name(found[0].name, found[1])}({', '.join(texts)})"
        return text if has_no_result(callee) else self._temporary(text)

    # objects and arrays

    def _kind(self, node: ast.expr) -> str | None:
        """Return "array", the dotted name of the class that holds arrays, or None of another object."""
        if isinstance(node, ast.Name):
            return self._blocks.get(node.id)
        return self._attribute_kind(node) if isinstance(node, ast.Attribute) else None

    def _attribute_kind(self, node: ast.Attribute) -> str | None:
        owner = self._kind(node.value) or ""
        origin = self.modules.get(owner.rpartition(".")[0])
        return origin.holders.get(owner, {}).get(node.attr) if origin else None

    def _handed(self, node: ast.expr, kind: str | None) -> str:
        """Return ``node`` as a function takes it that wants a ``kind``."""
        if kind is not None and self._kind(node) == kind:
            return self._known(node)
        room = ""
        if kind not in (None, ARRAY):
            room = self._name()
            self._line(f"{holder_type(kind)} {room};")
        return converted(self._object(node), kind, f"&{room}")

    def _known(self, node: ast.expr) -> str:
        """Return an array or what holds arrays: a parameter, or an attribute of one."""
        if isinstance(node, ast.Name):
            return c_local(node.id)
        assert isinstance(node, ast.Attribute)
        return f"{accessor(self._kind(node.value), node.attr)}({self._known(node.value)})"

    def _object(self, node: ast.expr) -> str:
        """Return what is handed on as it is: a parameter, or an attribute or element of one."""
        kind = self._kind(node)
        if kind and kind != ARRAY:
            return f"{self._known(node)}->object"
        if isinstance(node, ast.Name):
            if node.id not in self._given or kind:
                raise self.module.error(node, f"{node.id} is an array: what it is handed to has to say so")
            return c_local(node.id)
        if isinstance(node, ast.Attribute):
            return f"core_get({self._object(node.value)}, CORE_NAME({node.attr}))"
        if isinstance(node, ast.Subscript):
            return f"core_item({self._object(node.value)}, {self._value(node.slice)})"
        raise self.module.error(node, "an object is a parameter, or an attribute or element of one")

    def _pointer(self, call: ast.expr) -> str:
        assert isinstance(call, ast.Call)
        assert isinstance(call.func, ast.Name)
        kind, node = _TYPES[call.func.id], call.args[0]
        if isinstance(node, ast.Name) and node.id not in self._given:
            found = resolve(self.module, node.id, self.modules)
            assert found is not None
            name = c_name(found[0].name, found[1])
            self.tables[name] = found
            return f"({kind} *){name}"
        return f"({kind} *){self._handed(node, ARRAY)}"

    # values kept under a name

    def _name(self) -> str:
        self._count += 1
        return f"t{self._count}"

    def _kept(self, text: str) -> str:
        name = self._name()
        self._line(f"int32_t {name} = {text};")
        return name

    def _temporary(self, text: str) -> str:
        return self._kept(text) if self._keep else text


def _calls(node: ast.AST, writer: FunctionWriter) -> int:
    """Return how many hot functions an expression calls."""
    return sum(hot_function(writer.module, name, writer.modules) is not None for name, _ in calls(node))


def _reads(node: ast.AST) -> int:
    return sum(isinstance(n, ast.Subscript) for n in ast.walk(node))
