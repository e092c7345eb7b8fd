"""The core is imported leaves first: how deep its imports lie in one another costs no stack."""

import re

import pytest

from host import ROOT
from host.boards.build.frozen import ROLES, frozen_sources, select
from host.boards.build.generated import APPLICATION, LEAVES
from host.boards.build.leaves import behind_leaves, leaves_first
from host.boards.build.source import read_modules
from host.boards.runtimes import Wasi
from host.boards.runtimes.base import RuntimeFailure

DEEP = 60  # modules, each of which imports the next
ASK = "from probe.entry import FOUND\nprint('@@{\"found\": %d}' % FOUND)\n"


@pytest.fixture
def chain(tmp_path):
    """Sources with a chain of imports and a module that takes what its first one has of its last one."""
    for package in ("shared", "probe"):
        (tmp_path / "chain" / package).mkdir(parents=True)
        (tmp_path / "chain" / package / "__init__.py").write_text("")
    for number in range(DEEP):
        (tmp_path / f"chain/shared/link{number}.py").write_text(f"from .link{number + 1} import FOUND\n")
    (tmp_path / f"chain/shared/link{DEEP}.py").write_text("FOUND = 42\n")
    (tmp_path / "chain/probe/entry.py").write_text('"""Its line stays."""\nfrom shared.link0 import FOUND\n')
    return tmp_path / "chain"


@pytest.mark.parametrize("emitter", ["source", "bytecode"])
def test_a_deep_chain_of_imports_is_nothing_to_a_vm_of_32_bits(chain, tmp_path, emitter):
    runtime = Wasi(emitter)
    (tmp_path / "as_it_is").mkdir()
    with pytest.raises(RuntimeFailure, match="maximum recursion depth exceeded"):
        runtime.ask(runtime.prepare(chain, tmp_path / "as_it_is"), ASK)
    modules = read_modules(chain, ("shared", "probe"))
    (chain / "probe/entry.py").write_bytes(behind_leaves(modules["probe.entry"], modules))
    assert runtime.ask(runtime.prepare(chain, tmp_path), ASK) == {"found": 42}
    assert (chain / "probe/entry.py").read_text().splitlines()[1:] == ["from shared.link0 import FOUND"]


def test_what_needs_nothing_of_the_core_stays_as_it_is(chain):
    modules = read_modules(chain, ("shared", "probe"))
    assert behind_leaves(modules["probe"], modules) == b""


def needed(modules, name):
    return {need for need in modules[name].needs if need.startswith("shared.") and not modules[need].is_package}


@pytest.mark.parametrize("role", ROLES)
def test_nothing_is_imported_before_what_it_needs(role):
    modules = read_modules(ROOT)
    names = leaves_first(modules, select(modules, role))
    assert max(len(needed(modules, name)) for name in names) > 5
    for at, name in enumerate(names):
        assert needed(modules, name) <= set(names[:at])


@pytest.mark.parametrize("role", ROLES)
def test_a_board_imports_the_core_it_has_before_its_application(role, tmp_path):
    tree = frozen_sources(role, "caramelo", tmp_path / "frozen").modules
    imported = re.findall("^import (.+)$", (tree / LEAVES).read_text(), re.MULTILINE)
    there = {".".join(path.relative_to(tree).with_suffix("").parts) for path in (tree / "shared").rglob("*.py")}
    assert set(imported) == {name for name in there if not name.endswith("__init__")}
    lines = (tree / APPLICATION).read_text().splitlines()
    assert lines.index("from firmware import leaves") < lines.index(
        f"from firmware.start_{role} import WATCHDOG, armed, motor_supply_mV, start")


def test_packages_of_the_core_import_nothing():
    packages = [module for module in read_modules(ROOT, ("shared",)).values() if module.is_package]
    assert len(packages) > 5
    assert {module.name: module.needs for module in packages if module.needs} == {}
