"""What a ``@hot`` function may not contain: the rules of the viper emitter that its compiler does not check.

Viper works on machine words. It wraps silently, reads pointers unchecked and takes some Python
constructs through slow or allocating objects; each rule below names one such construct.
"""

import ast
from collections.abc import Iterator

from .source import Module, assignments, called, constant_value, has_no_result, is_name, resolve

POINTERS = ("ptr8", "ptr16", "ptr32")
REGISTERS = ("reg16", "reg32")  # pointers to a chip's registers, which change by themselves
MARKS = (*POINTERS, *REGISTERS)
_BUILTINS = (*MARKS, "int", "range")
_WORD = 1 << 30

_FORBIDDEN: tuple[tuple[type[ast.AST], str], ...] = (
    (ast.Tuple, "a tuple is an allocation (a two-element swap is the exception)"),
    (ast.List, "a list is an allocation"),
    (ast.Dict, "a dictionary is an allocation"),
    (ast.Set, "a set is an allocation"),
    (ast.Slice, "a slice is an allocation"),
    (ast.Starred, "star arguments are an allocation"),
    (ast.Lambda, "a closure is an allocation"),
    (ast.ListComp, "a comprehension is an allocation"),
    (ast.GeneratorExp, "a generator is an allocation"),
    (ast.Yield, "a generator cannot be viper"),
    (ast.YieldFrom, "a generator cannot be viper"),
    (ast.JoinedStr, "a string is an allocation"),
    (ast.Global, "a global that changes does not belong in the core"),
    (ast.Nonlocal, "a closure is an allocation"),
    (ast.Try, "an exception is an allocation"),
    (ast.Raise, "an exception is an allocation"),
    (ast.With, "with needs objects"),
    (ast.NamedExpr, "viper does not type :="),
    (ast.FunctionDef, "a function inside a function is a closure"),
    (ast.IfExp, "write the conditional as an if statement"),
)
_OPERATORS: dict[type, str] = {
    ast.Div: "/ gives a float: use //",
    ast.Pow: "** is not in viper: multiply",
    ast.MatMult: "@ is not in viper",
}


def check_hot(module: Module, function: ast.FunctionDef, modules: dict[str, Module]) -> None:
    """Raise BuildError with file, line and rule for the first rule that ``function`` breaks."""
    _check_signature(module, function)
    names = aliases(function)
    conditions = _conditions(function)
    negated = {id(n.operand) for n in ast.walk(function) if isinstance(n, ast.UnaryOp) and isinstance(n.op, ast.USub)}
    objects = _objects(function)
    statements = {id(node.value) for node in ast.walk(function) if isinstance(node, ast.Expr)}
    for node in _body(function):
        for kind, rule in _FORBIDDEN:
            if isinstance(node, kind) and not _is_swap(node, function):
                raise module.error(node, rule)
        _check_number(module, node, negated)
        _check_operator(module, node)
        _check_call(module, node, modules)
        _check_result(module, node, modules, statements)
        _check_return(module, node, function)
        _check_element(module, node, names, objects)
        _check_alias_use(module, node, names)
        _check_condition(module, node, conditions)
        _check_loop(module, node)
    if not has_no_result(function) and not _always_returns(function.body):
        raise module.error(function.body[-1], f"{function.name} is annotated -> int: it returns one on every path")


def aliases(function: ast.FunctionDef) -> dict[str, str]:
    """Return the local names that stand for a pointer, with its kind: ``table = ptr16(TAB)``, or a typed parameter."""
    made = {name: called(value) for name, value in assignments(ast.walk(function)) if called(value) in MARKS}
    typed = {given.arg: given.annotation.id for given in function.args.args if isinstance(given.annotation, ast.Name)}
    return made | {name: kind for name, kind in typed.items() if kind in MARKS}


def _body(function: ast.FunctionDef) -> Iterator[ast.AST]:
    for statement in function.body:
        yield from ast.walk(statement)


def _check_signature(module: Module, function: ast.FunctionDef) -> None:
    given = function.args
    if given.defaults or given.kw_defaults or given.vararg or given.kwarg or given.kwonlyargs or given.posonlyargs:
        raise module.error(function, f"{function.name}: a hot function takes positional parameters without defaults")
    for parameter in given.args:
        if parameter.annotation is not None and not is_name(parameter.annotation, "int"):
            raise module.error(parameter, f"{function.name}: {parameter.arg} is annotated int, or not if an array")
    if not is_name(function.returns, "int") and not has_no_result(function):
        raise module.error(function, f"{function.name}: a hot function is annotated -> int, or -> None")


def _check_number(module: Module, node: ast.AST, negated: set[int]) -> None:
    if isinstance(node, ast.Constant):
        if type(node.value) in (float, complex, bytes):
            raise module.error(node, f"{node.value!r}: a hot function knows integers only")
        if type(node.value) is int and node.value > _WORD - (id(node) not in negated):
            raise module.error(node, f"{node.value} is outside -2^30 .. 2^30-1")


def _check_operator(module: Module, node: ast.AST) -> None:
    operator = getattr(node, "op", None)
    if type(operator) in _OPERATORS:
        raise module.error(node, _OPERATORS[type(operator)])
    if not isinstance(node, ast.BinOp | ast.AugAssign):
        return
    right = constant_value(node.right if isinstance(node, ast.BinOp) else node.value, module.constants)
    if isinstance(operator, ast.LShift | ast.RShift) and right is not None and not 0 <= right < 32:
        raise module.error(node, f"shift by {right}: viper shifts by 0 .. 31")
    if isinstance(operator, ast.FloorDiv | ast.Mod) and right == 0:
        raise module.error(node, "division by zero gives 0 in viper, silently")


def _check_call(module: Module, node: ast.AST, modules: dict[str, Module]) -> None:
    if not isinstance(node, ast.Call):
        return
    if not isinstance(node.func, ast.Name):
        raise module.error(node, "a hot function calls functions by their name only")
    if node.keywords:
        raise module.error(node, f"{node.func.id}: keyword arguments are not in viper")
    if node.func.id in _BUILTINS:
        return
    callee = hot_function(module, node.func.id, modules)
    if callee is None:
        raise module.error(node, f"{node.func.id} is not a hot function: it returns an object")
    if len(callee.args.args) != len(node.args):
        raise module.error(node, f"{node.func.id} takes {len(callee.args.args)} arguments, {len(node.args)} given")


def _check_result(module: Module, node: ast.AST, modules: dict[str, Module], statements: set[int]) -> None:
    """A function without a result is called by a statement: viper would calculate with the address of None."""
    callee = hot_function(module, called(node), modules)
    if callee is not None and has_no_result(callee) and id(node) not in statements:
        raise module.error(node, f"{called(node)} has no result: call it as a statement")


def _check_return(module: Module, node: ast.AST, function: ast.FunctionDef) -> None:
    if isinstance(node, ast.Return) and (node.value is None) != has_no_result(function):
        rule = "None: return stands by itself" if node.value else "int: it returns one on every path"
        raise module.error(node, f"{function.name} is annotated -> {rule}")


def hot_function(module: Module, name: str, modules: dict[str, Module]) -> ast.FunctionDef | None:
    """Return the hot function known here as ``name``; None if that is not hot."""
    found = resolve(module, name, modules)
    return found[0].hot.get(found[1]) if found else None


def _check_element(module: Module, node: ast.AST, names: dict[str, str], objects: set[int]) -> None:
    """Objects may be handed on (to a pointer, to a function, to another attribute), not calculated with."""
    if isinstance(node, ast.Attribute) and id(node) not in objects:
        raise module.error(node, f".{node.attr} is an object: alias it first with ptr16 or ptr32")
    aliased = isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in names
    if isinstance(node, ast.Subscript) and id(node) not in objects and not aliased:
        raise module.error(node, "an element of an object: alias the array first with ptr16 or ptr32")


def _objects(function: ast.FunctionDef) -> set[int]:
    """Return the attributes and elements that stand where an object may: as an argument, or copied as they are."""
    found: set[int] = set()
    for node in ast.walk(function):
        places: list[ast.expr] = []
        if isinstance(node, ast.Call):
            places = node.args
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            places = [node.targets[0], node.value]
        for place in places:
            inner: ast.expr = place
            found.add(id(inner))
            while isinstance(inner, ast.Attribute | ast.Subscript) and isinstance(inner.value, ast.Attribute):
                inner = inner.value
                found.add(id(inner))
    return found


def _check_alias_use(module: Module, node: ast.AST, names: dict[str, str]) -> None:
    """A pointer handed on becomes a number: only elements of it may be used."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.Name) or not isinstance(child.ctx, ast.Load) or child.id not in names:
            continue
        if not (isinstance(node, ast.Subscript) and node.value is child):
            raise module.error(child, f"{child.id} is a pointer: hand on the array itself")


def _check_condition(module: Module, node: ast.AST, conditions: set[int]) -> None:
    truth = isinstance(node, ast.Compare | ast.BoolOp) or isinstance(getattr(node, "op", None), ast.Not)
    if truth and id(node) not in conditions:
        raise module.error(node, "a truth value is not a number in viper: use an if statement")
    if isinstance(node, ast.Compare) and any(isinstance(o, ast.In | ast.NotIn | ast.Is | ast.IsNot) for o in node.ops):
        raise module.error(node, "in and is compare objects: compare numbers")


def _check_loop(module: Module, node: ast.AST) -> None:
    if isinstance(node, ast.For):
        call = node.iter
        if not isinstance(call, ast.Call) or called(call) != "range":
            raise module.error(node, "a hot loop runs over range(...)")
        if len(call.args) == 3 and not constant_value(call.args[2], module.constants):
            raise module.error(node, "the step of a range must be a constant other than 0")


def _conditions(function: ast.FunctionDef) -> set[int]:
    """Return the nodes whose truth is asked for by if and while, through and, or, not; or kept under a name."""
    waiting: list[ast.AST] = [n.test for n in ast.walk(function) if isinstance(n, ast.If | ast.While)]
    waiting += [n.value for n in ast.walk(function) if isinstance(n, ast.Assign) and isinstance(n.value, ast.Compare)]
    found: set[int] = set()
    while waiting:
        node = waiting.pop()
        found.add(id(node))
        if isinstance(node, ast.BoolOp):
            waiting += node.values
        elif isinstance(node, ast.UnaryOp):
            waiting.append(node.operand)
    return found


def _always_returns(statements: list[ast.stmt]) -> bool:
    last = statements[-1]
    if isinstance(last, ast.If):
        return bool(last.orelse) and _always_returns(last.body) and _always_returns(last.orelse)
    return isinstance(last, ast.Return) and last.value is not None


def _is_swap(node: ast.AST, function: ast.FunctionDef) -> bool:
    """Return whether a tuple belongs to ``a, b = b, a``, which needs none."""
    if not isinstance(node, ast.Tuple) or len(node.elts) != 2:
        return False
    for statement in ast.walk(function):
        if isinstance(statement, ast.Assign) and node in (statement.targets[0], statement.value):
            return isinstance(statement.targets[0], ast.Tuple) and isinstance(statement.value, ast.Tuple)
    return False
