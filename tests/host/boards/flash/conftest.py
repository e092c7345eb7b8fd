"""Pretend boards need the unix VM and mpremote; they say more than real ones, and may be late on a busy machine."""

import pytest

from host.boards.flash import flash as flashing
from host.boards.flash import link
from host.boards.runtimes.unix import Unix
from tests.marks import skip_without
from tests.waiting import PATIENCE_S

from .trees import IN_ITS_LOOP


@pytest.fixture(autouse=True)
def pretend_boards(request, monkeypatch):
    if "PretendBoard" not in request.module.__dict__:
        return
    skip_without(Unix("bytecode"))
    pytest.importorskip("mpremote")
    monkeypatch.setattr(flashing, "DECIDED", (*flashing.DECIDED, IN_ITS_LOOP))
    monkeypatch.setattr(link, "PROMPT_TIMEOUT_S", PATIENCE_S / 20)  # a gait board lets it pass each time
    monkeypatch.setattr(link, "READ_TIMEOUT_S", PATIENCE_S / 20)
