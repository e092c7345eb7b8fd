"""The core's modules leaves first: each is imported behind all that it imports, so that no import nests in another.

An import within an import takes of a VM's stack, which is small on a board and in a browser's or WASI's 32-bit VM: one
dies of some ten. Who starts the core there imports it in this order beforehand; the sources need not care.
"""

from .rewrite import Places, apply_edits, beside
from .source import Module, closure

_CORE = "shared."


def leaves_first(modules: dict[str, Module], seeds: list[str]) -> list[str]:
    """Return the core's modules that ``seeds`` are or need, dotted, each behind all that it imports."""
    needed = [name for name in closure(modules, seeds) if name.startswith(_CORE) and not modules[name].is_package]
    return sorted(needed, key=lambda name: len(closure(modules, [name])))  # what imports another needs more than it


def behind_leaves(module: Module, modules: dict[str, Module]) -> bytes:
    """Return a module's text that imports what it needs of the core, leaves first; lines stay where they are."""
    names = leaves_first(modules, [module.name])
    if not names:
        return module.text
    place = Places(module.text)
    return apply_edits(module.text, [beside(module, module.tree, f"import {', '.join(names)}", place)])
