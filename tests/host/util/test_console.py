"""What is printed: nothing that came from elsewhere can make a terminal do anything."""

import ast
import io
import json
import unicodedata

import pytest
from rich.table import Table
from rich.text import Text

from host.util import console
from host.util.console import plain, say, screen, write_error, write_json
from tests import ROOT

# ESC sequences, C1 as one character, a title, backspace, writing direction, half a surrogate, markup that ends nothing.
FOREIGN = "a\x1b[2Jb\x9b31mc\x1b]0;title\x07d\x08e\u202ef\ud800g\x00h\x7fi[/x][red]j:smile:"
# These write to a program that reads their output, not to a person.
FOR_PROGRAMS = ("lab/parity/probe/", "lab/parity/checked.py")


def is_safe(text):
    """Return True if a terminal only shows the text."""
    return all(unicodedata.category(char) not in ("Cc", "Cf", "Cs") for char in text.replace("\n", ""))


def test_plain_escapes_what_is_obeyed_and_nothing_else():
    assert plain("\x1b[2J\x9b\x07\u202e\ud800\x7f") == "\\x1b[2J\\x9b\\x07\\u202e\\ud800\\x7f"
    assert plain("Größe 3 µm\n\tΩ → 犬 \U0001f436") == "Größe 3 µm\n\tΩ → 犬 \U0001f436"


def test_no_character_gets_through_that_is_obeyed():
    every = "".join(map(chr, range(0x110000)))
    assert is_safe(plain(every).replace("\t", ""))


@pytest.mark.parametrize("print_it", [
    say,
    write_error,
    lambda text: screen().print(text),
    lambda text: screen().print(Text(text, style="bold"), text, soft_wrap=True),
    lambda text: screen().print(f"wrote {text}", soft_wrap=True, style="red"),
])  # fmt: skip
def test_foreign_text_is_shown_and_not_obeyed(capsys, print_it):
    print_it(FOREIGN)
    shown = "".join(capsys.readouterr())
    assert is_safe(shown)
    together = shown.replace("\n", "")
    for piece in ("a\\x1b[2Jb\\x9b31mc", "\\ud800g\\x00h\\x7fi[/x][red]j:smile:"):
        assert piece in together


def test_foreign_text_in_a_table_is_shown_and_not_obeyed(capsys):
    table = Table("what", FOREIGN, title=FOREIGN)
    table.add_row("foreign", FOREIGN)
    screen().print(table)
    shown = capsys.readouterr().out
    assert is_safe(shown)
    assert "a\\x1b[2Jb" in shown


def test_on_a_terminal_the_own_styles_remain(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr(console.sys, "stdout", terminal)
    monkeypatch.setenv("TERM", "xterm")
    screen().print(Text(FOREIGN, style="bold"))
    shown = terminal.getvalue()
    assert shown.startswith("\x1b[1m")
    assert shown.count("\x1b") == 2  # bold and back, no more
    assert "\x9b" not in shown


def test_json_keeps_the_value_and_shows_no_control_character(capsys):
    value = {FOREIGN: [FOREIGN, "Größe 犬", "\x85\u2028"]}
    write_json(value)
    line = capsys.readouterr().out
    assert is_safe(line)
    assert line.count("\n") == 1
    assert json.loads(line) == value
    assert "Größe 犬" in line


def prints_elsewhere():
    """Yield the places in host/ where something other than host/util/console.py prints for a person."""
    for path in sorted((ROOT / "host").rglob("*.py")):
        name = str(path.relative_to(ROOT / "host"))
        if name.startswith(("util/console.py", *FOR_PROGRAMS)):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("print", "Console"):
                yield f"{name}: {ast.unparse(node)}"


def test_only_the_console_prints():
    own = {"cli.py: print(context.get_help())"}  # typer's help, of our own words
    assert set(prints_elsewhere()) - own == set()
