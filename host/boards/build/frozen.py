"""What is frozen into a board's image: the role's modules as MicroPython's own build takes them."""

from dataclasses import dataclass
from pathlib import Path

from ... import ROOT
from .c_core import MODULE, build_c_core
from .generated import generated_modules
from .leaves import leaves_first
from .lower import lowered_modules
from .rewrite import rewrite
from .source import PACKAGES, BuildError, Module, closure
from .tree import replace_tree

MAIN = "firmware/main.py"
ARCH = "armv7emsp"  # the STM32F405 of both boards

# What each kind of board starts from; everything these import comes along.
_COMMON = ("firmware/main.py", "firmware/startup.py", "firmware/selftest.py", "firmware/update.py")
ROLES: dict[str, tuple[str, ...]] = {
    "joint": (*_COMMON, "firmware/start_joint.py", "firmware/joint_selftest.py"),
    "gait": (*_COMMON, "firmware/start_gait.py"),
}


# What MicroPython's build needs of a C module: wrapping integers, and pointers of two kinds to one array. The ports'
# own -Os comes behind a module's flags, so speed is asked for where they ask for size.
_MAKE = ("SRC_USERMOD_C += $(USERMOD_DIR)/core.c\nCFLAGS_USERMOD += -fwrapv -fno-strict-aliasing\n"
         f"$(BUILD)/{MODULE}/core.o: COPT += -O3\n")


@dataclass(frozen=True)
class FrozenTree:
    """Folders with the modules to freeze, and with C modules to compile in (USER_C_MODULES), if there are any."""

    modules: Path
    c_modules: Path | None


def frozen_sources(role: str, robot: str, out: Path, emitter: str = "c", arch: str = ARCH) -> FrozenTree:
    """Write what a board of ``role`` runs below ``out`` in place of an earlier build. BuildError names file and line.

    ``robot`` is only looked at for a gait board: a name or a file. ``emitter``: "c" makes one C module of the hot
    functions, others are those of rewrite.py.
    """
    modules = lowered_modules(ROOT, PACKAGES)
    c_files, c_modules = dict[str, bytes](), None
    if emitter == "c":
        core = build_c_core(modules, select(modules, role), "micropython")
        texts, c_modules = dict(core.modules), out / "c"
        c_files = {f"c/{MODULE}/core.c": core.source.encode(), f"c/{MODULE}/micropython.mk": _MAKE.encode()}
    else:
        texts = {modules[name].path: rewrite(modules[name], modules, emitter, arch) for name in select(modules, role)}
    leaves = leaves_first(modules, [module.name for module in modules.values() if module.path in texts])
    texts["main.py"] = texts.pop(MAIN)  # MicroPython runs it as the main module
    texts |= {path: text.encode() for path, text in generated_modules(role, robot, leaves).items()}
    replace_tree({f"modules/{path}": text for path, text in texts.items()} | c_files, out)
    return FrozenTree(out / "modules", c_modules)


def select(modules: dict[str, Module], role: str) -> list[str]:
    """Return the dotted names of the modules that a role needs, in order."""
    starts = ROLES[role]
    seeds = [module.name for module in modules.values() if module.path.startswith(starts)]
    if not seeds:
        raise BuildError(f"role {role}: none of {', '.join(starts)} exists")
    return closure(modules, seeds)
