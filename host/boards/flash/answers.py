"""What a board may answer: its lines are read against these shapes before anything is done with them."""

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
    """What belongs to it is there, of its kind; nothing is turned into another kind."""

    model_config = ConfigDict(strict=True, frozen=True)


class Truth(Answer):
    """The answer to a question."""

    yes: bool


class Sectors(Answer):
    """What is to be erased, from low to high."""

    sectors: list[Sector]


class Log(Answer):
    """The board's log."""

    log: str


class Held(Answer):
    """What a slot holds."""

    build: str
    version: str
    sha256: Sha


class Report(Answer):
    """What the running firmware says of its start; ``error`` is empty and ``self_test`` "" when all went well."""

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
    """What a board is. ``wished`` is the last boot record: slot and starts left; None without one."""

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
        """The slot that does not run, and so the one that can be written."""
        return 1 - self.report.slot

    @property
    def settled(self) -> bool:
        """Return True if the running slot is to stay."""
        return self.wished in (None, (self.report.slot, CONFIRMED))
