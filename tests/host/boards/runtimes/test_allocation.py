"""No function of a tick takes memory, in bytecode nor as machine code: measured in the VMs, not hoped."""

import pytest

from host.boards.runtimes import Unix, Wasi
from host.lab.parity.figures import allocations
from host.lab.parity.table import rows_of
from tests.marks import NEEDS_UNIX

from .plant import plant


def test_nothing_of_a_tick_takes_memory_in_bytecode(bytecode, bound):
    ticks = {name: row for name, row in bytecode.items() if bound[name].ticks}
    assert len(ticks) > 100
    assert [name for name, row in ticks.items() if row.kept or not row.locked] == []


def takers(found, bound):
    return {name: row for name, row in found.items() if bound[name].ticks and (row.total or row.kept or not row.locked)}


@NEEDS_UNIX
def test_viper_code_takes_no_byte_for_frames_either(viper, bound):
    assert takers(viper, bound) == {}


@NEEDS_UNIX
def test_native_code_takes_no_byte_for_frames_either(sources, tmp_path, bound):
    assert takers(allocations(Unix("native"), sources, tmp_path), bound) == {}


@NEEDS_UNIX
def test_every_function_of_a_tick_has_a_row_in_the_table_of_memory(largest, bound, bytecode, viper):
    rows = rows_of(largest, bound, bytecode, viper)
    assert {row.name for row in rows} == {name for name in largest if bound[name].ticks}
    assert [row for row in rows if row.kept or row.viper] == []
    assert all(row.bits <= 30 for row in rows)


@pytest.mark.parametrize("gait", ["paper-trot", "trot", "crawl"])
def test_2000_ticks_in_a_row_run_while_the_heap_is_locked(sources, tmp_path, gait):
    runtime = Wasi()
    tree = runtime.prepare(sources, tmp_path)
    answer = runtime.ask(tree, f"from probe import measure\nmeasure.locked('planner', 'tick:{gait}', 2400)\n")
    assert answer["ticks"] == 2400
    assert answer["walked"] > 1000  # the others stand up, stand, or come from another gait


@pytest.mark.parametrize(
    "wrong",
    ["(value, low, high)[0]", "int(value + 0.25)", "value + (1 << 30) - (1 << 30)", "[value][0]"],
    ids=["tuple", "float", "2^30", "list"],
)
def test_a_planted_allocation_is_found(sources, tmp_path, wrong):
    right = "        return high\n    return value\n"
    copy = plant(sources, tmp_path, "shared/num/fixed.py", right, right.replace("value", wrong))
    runtime = Wasi("source")
    tree = runtime.prepare(copy, tmp_path)
    rows = runtime.ask(tree, "from probe import measure\nmeasure.allocation('fixed', 24)\n")["rows"]
    name, _, total, kept, locked = rows[0]
    assert name == "saturate"
    assert (total > 0, kept > 0, locked) == (True, True, False)
    assert [row[0] for row in rows[1:] if not row[4]] == []
