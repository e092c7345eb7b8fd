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


def converted(text: str, kind: str | None) -> str:
    """Return an object as a hot function takes it that wants a ``kind``."""
    if kind is None:
        return text
    return f"core_block({text})" if kind == ARRAY else f"&({holder_type(kind)}){{.object = {text}}}"


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
    texts[kind] = "\n".join([*lines, *(_find(kind, attribute, of) for attribute, of in held.items())])


def _find(kind: str, attribute: str, of: str) -> str:
    array = of == ARRAY
    place = f"held->{attribute}_" if array else f"held->{attribute}_.object"
    asked = f"core_get(held->object, CORE_NAME({attribute}))"
    return (f"static {c_type(of)}{accessor(kind, attribute)}({holder_type(kind)} *held) {{\n"
            f"    if (!{place}) {place} = {f'core_block({asked})' if array else asked};\n"
            f"    return {'' if array else '&'}held->{attribute}_;\n}}")
