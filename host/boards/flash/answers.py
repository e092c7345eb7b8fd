"""The shapes of a board's answers: its lines are checked against them before anything uses them.

An answer of a single value needs none: it is a bool, a str, or a list of Sector.
"""

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from firmware.flash_map import CONFIRMED, SECTOR_KIB, SLOTS

Sha = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
Sector = Annotated[int, Field(ge=0, lt=len(SECTOR_KIB))]


def _slot_number(letter: object) -> int:
    if not isinstance(letter, str) or letter not in tuple(SLOTS):
        raise ValueError("no slot: a or b")
    return SLOTS.index(letter)


class Answer(BaseModel):
    """Common to all answers: every field is there and has its type; no type is converted."""

    model_config = ConfigDict(strict=True, frozen=True)


class Held(Answer):
    """The content of a slot."""

    build: str
    version: str
    sha256: Sha


class Report(Answer):
    """The running firmware's report on its start; ``error`` and ``self_test`` are empty if all went well."""

    slot: Annotated[int, BeforeValidator(_slot_number)]
    stage: str
    self_test: str | None
    error: str
    confirmed: bool
    board: str
    build: str
    role: str
    version: str
    protocol: int | None


class Survey(Answer):
    """What a board is. ``wished`` is the last boot record: slot and remaining starts; None without one."""

    version: tuple[int, int, int]
    report: Report
    slots: tuple[Held | None, Held | None]
    wished: tuple[Annotated[int, Field(ge=0, le=1)], int] | None
    supply_mV: int | None

    @property
    def micropython(self) -> str:
        """MicroPython's version."""
        return ".".join(map(str, self.version))

    @property
    def other(self) -> int:
        """The slot that does not run, which can therefore be written."""
        return 1 - self.report.slot

    @property
    def settled(self) -> bool:
        """Return True if the running slot is confirmed."""
        return self.wished in (None, (self.report.slot, CONFIRMED))
