"""The table in docs/core.md is what the VMs say today."""

from host.parity.table import PAGE, on_page, put_on_page, table_of

from ..marks import NEEDS_UNIX


def test_a_table_is_put_on_the_page_and_found_there_again():
    page = PAGE.read_text()
    assert on_page(put_on_page(page, "another\n")) == "another\n"
    assert put_on_page(put_on_page(page, "another\n"), on_page(page)) == page


@NEEDS_UNIX
def test_the_table_is_up_to_date(largest, bound, bytecode, viper):
    table = table_of(largest, bound, bytecode, viper)
    assert on_page(PAGE.read_text()) == table, "python -m host.parity.table writes it"
