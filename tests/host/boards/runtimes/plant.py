"""Plants a mistake into a copy of the core: the checks have to find it."""

import shutil
from pathlib import Path


def plant(sources: Path, work: Path, path: str, right: str, wrong: str) -> Path:
    """Return a copy of ``sources`` in which ``right``, which must be there once, became ``wrong``."""
    copy = work / "planted"
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copytree(sources, copy)
    file = copy / path
    text = file.read_text()
    assert text.count(right) == 1, f"{path} no longer holds {right!r}"
    file.write_text(text.replace(right, wrong))
    return copy
