"""`caramelo parity --memory`: a row for every function of a tick, and none keeps a byte."""

from host.lab.parity.table import rows_of
from tests.marks import NEEDS_UNIX


@NEEDS_UNIX
def test_every_function_of_a_tick_has_a_row_and_keeps_nothing(largest, bound, bytecode, viper):
    rows = rows_of(largest, bound, bytecode, viper)
    assert {row.name for row in rows} == {name for name in largest if bound[name].ticks}
    assert [row for row in rows if row.kept or row.viper] == []
    assert all(row.bits <= 30 for row in rows)
