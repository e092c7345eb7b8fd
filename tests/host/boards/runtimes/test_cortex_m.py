"""The emulated Cortex-M4, where it is installed; what it counts, and the reason it gives where it is not."""

import pytest

from host.boards.runtimes import CortexM
from host.boards.runtimes.cortex_m import image_path, instructions
from host.lab.parity.bench import INSTRUCTIONS_MOST
from host.lab.parity.figures import instructions as counted
from tests.marks import skip_without


@pytest.mark.parametrize(
    ("code", "count"),
    [("7047", 1), ("10b510bd", 2), ("40f20002", 1), ("fff7feff10bd", 2), ("00e0fee7", 2)],
    ids=["bx", "push, pop", "movw", "bl, pop", "b, b"],
)
def test_thumb_instructions_have_two_or_four_bytes(code, count):
    assert instructions(bytes.fromhex(code)) == count


def test_without_its_image_it_says_where_that_belongs(monkeypatch, tmp_path):
    monkeypatch.setenv("CARAMELO_CORTEX_M", str(tmp_path / "none.bin"))
    reason = CortexM().missing()
    assert reason is not None
    assert "unicorn" in reason or str(image_path()) in reason


@pytest.mark.slow
def test_the_current_step_needs_no_more_instructions_than_the_first_prototype(sources, tmp_path):
    runtime = CortexM(counting=True)
    skip_without(runtime)
    found = counted(runtime, sources, tmp_path)
    assert 400 < found["joint.current_step"] <= INSTRUCTIONS_MOST["joint.current_step"]
