"""Pretend boards need the unix VM and mpremote; flashing them need not wait as for real ones, which say less."""

import pytest

from host.boards.flash import flash as flashing
from host.boards.runtimes.unix import Unix
from tests.marks import skip_without

from .trees import IN_ITS_LOOP


@pytest.fixture(autouse=True)
def quick_boards(request, monkeypatch):
    if "PretendBoard" not in request.module.__dict__:
        return
    skip_without(Unix("bytecode"))
    pytest.importorskip("mpremote")
    monkeypatch.setattr(flashing, "DECIDED", (*flashing.DECIDED, IN_ITS_LOOP))
