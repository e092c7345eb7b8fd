"""Every notebook runs from its first cell to its last, and comes out with what it shows."""

import pytest

from tests import ROOT

FOLDER = ROOT / "examples" / "notebooks"
LONGEST_CELL_S = 300  # a walk of some seconds takes one
# What the cells of each print or return, and how many pictures it draws.
SHOWS = {
    "first_walk": (["standing", "x 0.3", "in truth x 0.", "200"], 1),
    "own_robot": (["'mine'", "wrong.toml: geometry.thigh_m: value 12: allowed", "'caramelo': 0."], 0),
    "inside_the_core": (["1 lu is 7.6 micrometres", "0.0"], 3),
}


def outputs(notebook):
    for cell in notebook.cells:
        yield from cell.get("outputs", [])


def test_every_notebook_is_looked_at():
    assert sorted(path.stem for path in FOLDER.glob("*.ipynb")) == sorted(SHOWS)


@pytest.mark.parametrize("name", SHOWS)
def test_a_notebook_is_kept_without_what_it_shows(name):
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", 4)
    nbformat.validate(notebook)
    assert list(outputs(notebook)) == []


@pytest.mark.parametrize("name", SHOWS)
def test_a_notebook_runs(name, tmp_path, monkeypatch):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", 4)
    nbclient.NotebookClient(notebook, timeout=LONGEST_CELL_S, resources={"metadata": {"path": str(tmp_path)}}).execute()
    texts = [each.get("text") or each["data"].get("text/plain", "") for each in outputs(notebook)]
    words, pictures = SHOWS[name]
    for each in words:
        assert any(each in text for text in texts), (each, texts)
    assert sum("image/png" in each.get("data", {}) for each in outputs(notebook)) == pictures
