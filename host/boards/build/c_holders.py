"""Objects that hold arrays, in C: a hot function is handed a struct of the addresses that are known so far.

Asking an object for an attribute costs a hundred and more instructions. So the first to ask keeps the address, for as
long as the call from Python lasts: within it only hot functions run, and one that sets an attribute forgets its
address.
"""

from .source import Module

ARRAY = "array"


def c_type(kind: str | None) -> str:
    """Return the C type of a parameter that is no number: "array", the dotted name of a holder, None: any object."""
    if kind is None:
        return "core_obj "
    return "int32_t *" if kind == ARRAY else f"{holder_type(kind)} *"


def holder_type(kind: str) -> str:
    """Return the C name of the struct of a class, given by its dotted name."""
    return kind.replace(".", "_")


def accessor(kind: str | None, attribute: str) -> str:
    """Return the C name of the function that finds an attribute of a class."""
    assert kind is not None
    return f"{holder_type(kind)}__{attribute}"


def converted(text: str, kind: str | None, room: str = "") -> str:
    """Return an object as a hot function takes it that wants a ``kind``; ``room``: the address of a holder's struct."""
    if kind is None:
        return text
    return f"core_block({text})" if kind == ARRAY else f"{holder_type(kind)}_of({room}, {text})"


def room_of(kind: str | None) -> str:
    """Return the address of a struct that lasts as long as the C function that asks for it."""
    return "" if kind in (None, ARRAY) else f"__builtin_alloca(sizeof({holder_type(kind)}))"


def holders_text(chosen: list[Module], modules: dict[str, Module]) -> str:
    """Return the structs of all classes that hot functions of ``chosen`` take, and what finds their attributes."""
    texts: dict[str, str] = {}
    for module in chosen:
        for blocks in module.blocks.values():
            for kind in sorted({kind for kind in blocks.values() if kind != ARRAY}):
                _add(kind, modules, texts)
    return "\n".join(texts.values())


def _add(kind: str, modules: dict[str, Module], texts: dict[str, str]) -> None:
    """Add a class to ``texts``, after those that it holds."""
    if kind in texts:
        return
    held = modules[kind.rpartition(".")[0]].holders[kind]
    for inner in held.values():
        if inner != ARRAY:
            _add(inner, modules, texts)
    name = holder_type(kind)
    types = {attribute: "int32_t *" if of == ARRAY else f"{holder_type(of)} " for attribute, of in held.items()}
    members = [f"{of}{attribute}_;" for attribute, of in types.items()]
    lines = ["typedef struct {", "    core_obj object;", *(f"    {member}" for member in members), f"}} {name};"]
    texts[kind] = "\n".join([*lines, _make(name, held), *(_find(kind, at, of) for at, of in held.items())])


def _make(name: str, held: dict[str, str]) -> str:
    """Return the function that begins a struct: nothing is known. Store by store: memset of so few takes far longer."""
    members = [f"{attribute}_" if of == ARRAY else f"{attribute}_.object" for attribute, of in held.items()]
    forget = "".join(f" held->{member} = 0;" for member in members)
    return (f"static inline {name} *{name}_of({name} *held, core_obj object) {{\n"
            f"    held->object = object;{forget}\n    return held;\n}}")


def _find(kind: str, attribute: str, of: str) -> str:
    array = of == ARRAY
    place = f"held->{attribute}_" if array else f"held->{attribute}_.object"
    asked = f"core_get(held->object, CORE_NAME({attribute}))"
    found = f"{place} = core_block({asked})" if array else converted(asked, of, f"&held->{attribute}_")
    return (f"static {c_type(of)}{accessor(kind, attribute)}({holder_type(kind)} *held) {{\n"
            f"    if (!{place}) {found};\n"
            f"    return {'' if array else '&'}held->{attribute}_;\n}}")
