"""docs/python.md and the README are true: their Python runs, and every name of the library is told."""

import re

import pytest

import caramelo
from tests import ROOT

PAGES = ("docs/python.md", "README.md")
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)


def blocks(page):
    return BLOCK.findall((ROOT / page).read_text())


@pytest.mark.parametrize("page", PAGES)
def test_the_python_of_a_page_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert blocks(page)
    for block in blocks(page):
        exec(compile(block, page, "exec"), {})
        assert capsys.readouterr().out, "it prints what it did"


def test_the_readme_shows_ten_lines():
    """Requirement: ten lines of Python on the first page."""
    (block,) = blocks("README.md")
    assert len(block.splitlines()) <= 10


def test_every_name_is_told():
    text = (ROOT / "docs/python.md").read_text()
    names = [name for name in vars(caramelo.Robot) if not name.startswith("_")] + list(caramelo.__all__)
    untold = [name for name in names if not re.search(rf"\b{name}\b", text)]
    assert untold == ["Odometry", "Sensed"], "types that nobody makes by hand"
