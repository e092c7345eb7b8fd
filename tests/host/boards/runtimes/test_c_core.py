"""Objects that hold arrays, in the C that a board's image is made of: found once, and anew when an attribute is set."""

import shutil
import subprocess
import sys

import pytest

from host import ROOT
from host.boards.build.c_core import build_c_core
from host.boards.build.lower import lowered_modules
from host.boards.build.source import BuildError
from host.boards.runtimes import CCore
from tests.marks import skip_without

HELD = '''
from .runtime import Ints, const, hot, zeros


class Inner:
    def __init__(self):
        self.total = zeros(1)


class Outer:
    def __init__(self):
        self.rows = [zeros(2), zeros(2)]
        self.row = self.rows[0]
        self.inner = Inner()


@hot
def add(into: Ints, value: int) -> int:
    into[0] += value
    return into[0]


@hot
def choose(outer: Outer, which: int) -> None:
    if which > 1:
        return
    outer.row = outer.rows[which]


@hot
def note(inner: Inner, value: int) -> int:
    return add(inner.total, value)


@hot
def both(outer: Outer, value: int) -> int:
    add(outer.row, value)
    choose(outer, 1)
    choose(outer, add(outer.row, 0) + add(outer.inner.total, 0) + 2)
    add(outer.row, 2 * value)
    return note(outer.inner, value)
'''
RUN = """
from shared.held import Outer, both, choose
outer = Outer()
assert choose(outer, 0) is None
print(both(outer, 3), both(outer, 4), [list(row) for row in outer.rows], outer.row is outer.rows[1])
"""


@pytest.fixture
def held(tmp_path):
    (tmp_path / "sources/shared").mkdir(parents=True)
    for name in ("__init__.py", "runtime.py", "record.py"):
        shutil.copy(ROOT / "shared" / name, tmp_path / "sources/shared" / name)
    (tmp_path / "sources/shared/held.py").write_text(HELD)
    return tmp_path / "sources"


def printed(tree):
    return subprocess.run([sys.executable, "-c", RUN], cwd=tree, capture_output=True, text=True, check=True).stdout


def test_an_attribute_that_is_set_is_found_anew(held, tmp_path):
    skip_without(CCore())
    assert printed(held) == "3 7 [[3, 0], [18, 0]] True\n"
    assert printed(CCore().prepare(held, tmp_path)) == printed(held)


def test_an_array_handed_to_what_takes_any_object_is_refused(held):
    path = held / "shared/held.py"
    mark = "@hot\ndef choose("
    path.write_text(HELD.replace(mark, "@hot\ndef take(any) -> int:\n    return 1\n\n\n" + mark)
                    + "\n\n@hot\ndef on(row: Ints) -> int:\n    return take(row)\n")
    modules = lowered_modules(held, ("shared",))
    with pytest.raises(BuildError, match=r"shared/held.py:\d+: row is an array: what it is handed to has to say so"):
        build_c_core(modules, sorted(modules), "cpython", whole=True)


def test_a_class_that_sets_up_nothing_of_its_own_is_the_one_it_is_derived_from(held):
    path = held / "shared/held.py"
    derived = "class Derived(Outer):\n    def __init__(self):\n        super().__init__()\n\n\n"
    path.write_text(HELD.replace("@hot\ndef choose(", derived + "@hot\ndef choose(")
                    + "\n\n@hot\ndef again(derived: Derived) -> int:\n    return both(derived, 1)\n")
    modules = lowered_modules(held, ("shared",))
    source = build_c_core(modules, sorted(modules), "cpython", whole=True).source
    assert "Derived" not in source
    assert "both(derived_, 1)" in source


def test_a_name_asked_of_a_module_is_refused_where_names_are_dropped(held):
    """An image keeps what is imported by name; a constant is a number there, and gone from its module."""
    (held / "shared/user.py").write_text("from . import held as h\n\n\ndef count():\n    return h.Inner\n")
    modules = lowered_modules(held, ("shared",))
    with pytest.raises(BuildError, match=r"shared/user.py:5: h.Inner: import the name Inner, not its module"):
        build_c_core(modules, ["shared.user"], "micropython")
