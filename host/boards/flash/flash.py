"""Flashes one board: look, decide, write the slot that does not run, compare, switch, start, ask, confirm.

At any moment the board starts a complete firmware: until the boot record is written the old one, then the new one, and
the old one again if the new one is not confirmed.
"""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass

from firmware.flash_map import SLOTS, TRIAL_STARTS
from firmware.startup_words import FAILED, RUNNING, STARTED, STOPPED
from shared.wire.names import PROTOCOL_HASH

from ...util.errors import UserError
from ..build.image_file import ImageFile
from .answers import Report, Survey
from .board import Board, NoFirmware
from .link import PROMPT, BoardError, BoardLink, stopped

SETTLE_S = 6.0  # to wait for the board's message that it started; messages before USB is open are lost (chosen)
GRACE_S = 1.0  # within this time an application that can't run fails (chosen)
DECIDED = (PROMPT,)  # what a board says when it is clear already how its start went
ANSWER_TRIES = TRIAL_STARTS + 3
MOTOR_OFF_MV = 5500  # USB alone may lift a board's supply to 5 V (assumed); motors run from 12 V up


@dataclass(frozen=True)
class Wish:
    """The firmware and id that the board should have."""

    image: ImageFile
    node: int | None = None
    dry_run: bool = False


@dataclass
class Outcome:
    """What was done to a board, and its answer now. ``bytes`` were written; 0 if the slot already held them."""

    port: str
    build: str
    slot: str
    changed: bool
    dry_run: bool
    bytes: int
    version: str | None = None
    protocol: int | None = None
    self_test: str | None = None


Progress = Callable[[float, float], None]  # bytes done, total bytes


def flash(port: str, wish: Wish, progress: Progress = lambda done, total: None) -> Outcome:
    """Bring one board to the wanted state. UserError before anything is written, BoardError after."""
    with stopped(port) as link:
        return _flash(link, wish, progress)


def _flash(link: BoardLink, wish: Wish, progress: Progress) -> Outcome:
    board = Board(link)
    survey = board.survey()
    check_board(link.port, wish, survey)
    if not survey.settled and not wish.dry_run:
        board, survey = _back_to_settled(link, board, survey)
    runs = _holds(board, survey, survey.report.slot, wish.image)
    target = survey.report.slot if runs else survey.other
    waits = not runs and not _holds(board, survey, target, wish.image)
    data = wish.image.slots[target]
    changed = not runs or wish.node is not None
    about = wish.image.about
    outcome = Outcome(link.port, about.build, SLOTS[target], changed, wish.dry_run, len(data) if waits else 0)
    if wish.dry_run or not changed:
        outcome.version, outcome.protocol = survey.report.version, survey.report.protocol
        return outcome
    if waits:
        board.write(data, progress)
    if wish.node is not None:
        board.set_node(wish.node)
    if not runs:
        board.activate()
    link.reset()
    _confirm(link, wish, target, outcome)
    return outcome


def check_board(port: str, wish: Wish, survey: Survey) -> None:
    """UserError if the image is not for this board or these sources, or if the motor supply is on."""
    about, report = wish.image.about, survey.report
    if report.board != about.board:
        raise UserError(f"{port}: is a {report.board}, but the image is for a {about.board}, role {about.role}")
    if wish.node is not None and about.role != "joint":
        raise UserError(f"--id {wish.node}: only for joints; this image is for the role {about.role}")
    if about.protocol not in (None, PROTOCOL_HASH):
        raise UserError(
            f"{port}: the image speaks protocol {about.protocol:#x}, this computer {PROTOCOL_HASH:#x}: "
            f"build the image again (caramelo firmware image)"
        )
    if survey.supply_mV is not None and survey.supply_mV > MOTOR_OFF_MV:
        raise UserError(
            f"{port}: the motor supply is on, {survey.supply_mV / 1000:.1f} V: switch it off, then flash again"
        )


def _holds(board: Board, survey: Survey, slot: int, image: ImageFile) -> bool:
    """Return True if a slot already holds its half of the image, to the byte."""
    held = survey.slots[slot]
    return held is not None and held.sha256 == image.header(slot).sha256.hex() and board.is_whole(slot)


def _back_to_settled(link: BoardLink, board: Board, survey: Survey) -> tuple[Board, Survey]:
    """Let a board on trial start the slot that worked before: the running one can't be written and is not confirmed."""
    if survey.slots[survey.other] is None or not board.is_whole(survey.other):
        return board, survey  # no slot to go back to
    board.go_back()
    link.reset()
    board = _started(link)
    return board, board.survey()


def _confirm(link: BoardLink, wish: Wish, target: int, outcome: Outcome) -> None:
    """Wait until the new firmware runs, check its report and confirm it."""
    board, report = _running(link, target)
    outcome.version, outcome.protocol = report.version, report.protocol
    outcome.self_test = "passed"
    about = wish.image.about
    if report.build != about.build:
        raise BoardError(f"{link.port}: runs build {report.build}, not {about.build}: flash again")
    if not report.confirmed:
        board.confirm()
    if wish.node is not None and board.node_waits():
        raise BoardError(
            f"{link.port}: the joint did not take over id {wish.node}: its stored parameters are broken; "
            f"caramelo joints params restore, then flash again"
        )


def _running(link: BoardLink, target: int) -> tuple[Board, Report]:
    """Return the report of the wanted slot once its application has run; BoardError if the board went back."""
    report: Report | None = None
    for _ in range(ANSWER_TRIES):
        try:
            board = _started(link)
            report = board.report()
        except NoFirmware:
            link.reset()  # it can't even be asked: use up its starts
            continue
        except UserError:
            link.close()  # it reset in the middle of an answer
            continue
        ran = report.stage in (RUNNING, STOPPED)
        if ran and report.slot == target and report.self_test == "":
            return board, report
        if ran or (report.stage == FAILED and report.confirmed):
            break
        link.reset()  # interrupted or failed: it starts again, three times at most
    why = _last_line(link)
    if report is None:
        raise BoardError(f"{link.port}: the board did not come back after its reset: plug it in again")
    raise BoardError(
        f"{link.port}: the new firmware did not start{why}; the board is on slot {SLOTS[report.slot]} "
        f"with build {report.build}"
    )


def _started(link: BoardLink) -> Board:
    """Return the board once it is back and a moment after it reports that its application has started."""
    link.wait_until_back()
    heard = bytearray()

    def decided(data: bytes = b"") -> bool:
        heard.extend(data)
        return any(words in heard for words in DECIDED)

    link.listen(SETTLE_S, lambda data: decided(data) or STARTED.encode() in heard)
    if not decided():
        link.listen(GRACE_S, decided)
    link.interrupt()
    return Board(link)


def _last_line(link: BoardLink) -> str:
    """Return the last line about a failure in the board's log, after a colon."""
    with contextlib.suppress(UserError):
        link.interrupt()
        lines = [line for line in Board(link).log().splitlines() if "was not confirmed" not in line]
        return f": {lines[-1]}" if lines else ""
    return ""
