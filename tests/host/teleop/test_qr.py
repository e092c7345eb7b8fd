"""The QR code in the terminal: what is printed is the code's modules, and the address is the page's with its code."""

import io

import segno

from host.teleop.qr import PLAIN, QUIET, WHITE, page_address, qr_lines, shows_blocks

BLOCKS = {" ": (1, 1), "▀": (0, 1), "▄": (1, 0), "█": (0, 0)}  # a module and the one below it; 1 is dark


def test_what_is_printed_are_the_modules_with_their_quiet_zone():
    text = page_address("192.168.1.23", 8080, "123456")
    lines = [line.removeprefix(WHITE).removesuffix(PLAIN) for line in qr_lines(text)]
    rows = [[BLOCKS[char][half] for char in line] for line in lines for half in (0, 1)]
    wanted = [list(row) for row in segno.make_qr(text, error="l").matrix_iter(border=QUIET)]
    assert rows[: len(wanted)] == wanted
    assert len(rows) - len(wanted) < 2


def test_the_address_is_one_that_a_phone_reaches():
    assert page_address("192.168.1.23", 8080, "123456") == "http://192.168.1.23:8080/#123456"
    assert page_address("fe80::1", 80, "123456") == "http://[fe80::1]:80/#123456"
    everywhere = page_address("0.0.0.0", 8080, "123456")
    assert everywhere.endswith(":8080/#123456")
    assert "0.0.0.0" not in everywhere


class Terminal(io.TextIOWrapper):
    def isatty(self):
        return True


def test_it_is_printed_only_where_it_can_be_seen():
    assert shows_blocks(Terminal(io.BytesIO(), encoding="utf-8"))
    assert not shows_blocks(Terminal(io.BytesIO(), encoding="ascii"))
    assert not shows_blocks(io.TextIOWrapper(io.BytesIO(), encoding="utf-8"))
