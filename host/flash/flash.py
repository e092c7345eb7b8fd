"""Flashes one board: look, decide, write the slot not in use, compare, switch by one rename, start, ask back, confirm.

At any moment the board starts a whole firmware: until the pointer file is renamed the old one, from then on the new
one, and the old one again if the new one is not confirmed.
"""

import contextlib
import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from firmware.slots import FAILED, POINTER, RUNNING, STARTED, STARTS, STOPPED, pack_pointer

from ..build.image import MANIFEST, Image
from ..errors import UserError
from ..runtimes.board import ARCHES
from .board_files import NODE_FILE, ROOT_FILES, BoardFiles, Survey, check_filesystem
from .link import BoardError, BoardLink
from .plan import Plan, check_board, check_space, make_plan

SETTLE_S = 6.0  # waited for the board to say that it started; what it says before USB is open is lost (chosen)
GRACE_S = 1.0  # in which an application that can't run fails (chosen)
ANSWER_TRIES = STARTS + 3


@dataclass(frozen=True)
class Wish:
    """What is to be on the board. ``image`` builds for a processor: emitter and mpy-cross arch in, image out."""

    role: str
    image: Callable[[str, str], Image]
    slot: str = "auto"
    node: int | None = None
    dry_run: bool = False


@dataclass
class Outcome:
    """What was done to a board, and what it answers now."""

    port: str
    build: str = ""
    slot: str = ""
    changed: bool = False
    dry_run: bool = False
    uploaded: list[str] = field(default_factory=list)
    copied: list[str] = field(default_factory=list)
    removed: list[str] = field(default_factory=list)
    bytes: int = 0
    version: str | None = None
    protocol: int | None = None
    self_test: str | None = None


Progress = Callable[[float, float], None]  # bytes done, bytes in all


def flash(port: str, wish: Wish, progress: Progress = lambda done, total: None) -> Outcome:
    """Bring one board to what is wished. UserError before anything is written, BoardError after."""
    with BoardLink(port) as link:
        try:
            return _flash(link, wish, progress)
        except UserError:
            _leave_running(link)
            raise


def _flash(link: BoardLink, wish: Wish, progress: Progress) -> Outcome:
    files = BoardFiles(link)
    survey = files.survey()
    image = wish.image(*target_of(link.port, survey))
    check_board(link.port, image, survey)
    check_filesystem(link.port, survey)
    _check_role(wish)
    plan = make_plan(link.port, image, survey, wish.slot)
    check_space(link.port, plan, survey)
    outcome = _planned(link.port, wish, plan, image)
    if wish.dry_run or not outcome.changed:
        report = survey.report or {}
        outcome.version, outcome.protocol = report.get("version"), report.get("protocol")
        _leave_running(link)
        return outcome
    if not plan.done:
        _write(files, plan, survey, image, progress)
    if wish.node is not None:
        files.replace(NODE_FILE, f"{wish.node}\n".encode())
    _switch(files, plan)
    link.reset()
    _confirm(link, wish, plan, image, outcome)
    return outcome


def target_of(port: str, survey: Survey) -> tuple[str, str]:
    """Return emitter and arch for a board: viper for its processor; bytecode where it runs no machine code."""
    number = survey.mpy >> 10 & 0xF
    if number >= len(ARCHES):
        raise UserError(f"{port}: processor number {number} is not known to this build")
    arch = ARCHES[number]
    return ("viper", arch) if arch else ("bytecode", "any")


def _planned(port: str, wish: Wish, plan: Plan, image: Image) -> Outcome:
    return Outcome(
        port,
        build=str(image.manifest["build"]),
        slot=plan.slot,
        changed=not plan.done or wish.node is not None,
        dry_run=wish.dry_run,
        uploaded=sorted([*plan.upload, *plan.root]),
        copied=sorted(plan.copy),
        removed=list(plan.stale),
        bytes=plan.size,
    )


def _check_role(wish: Wish) -> None:
    if wish.node is not None and wish.role != "joint":
        raise UserError(f"--id {wish.node}: only joints have one; this is the role {wish.role}")


def _write(files: BoardFiles, plan: Plan, survey: Survey, image: Image, progress: Progress) -> None:
    """Fill the slot and the root; the slot that starts stays as it is."""
    if not plan.same:
        _protect(files, plan, survey)
        _fill(files, plan, survey, progress)
        _compare(files, plan, image)
    for path, data in plan.root.items():
        files.replace(path, data)


def _protect(files: BoardFiles, plan: Plan, survey: Survey) -> None:
    """Take a pointer away from a slot that is about to be taken apart."""
    if survey.pointer is not None and survey.pointer[0] == plan.slot and plan.kept:
        files.replace(POINTER, pack_pointer(plan.kept, "-", 0, 1).encode())


def _fill(files: BoardFiles, plan: Plan, survey: Survey, progress: Progress) -> None:
    manifest = f"{plan.slot}/{MANIFEST}"
    if manifest in survey.files:
        files.remove(manifest)  # from here on the slot is incomplete
    for path in plan.removed:
        files.remove(path)
    for folder in plan.stale_folders:
        files.remove_folder(folder)
    for folder in plan.folders:
        if folder not in survey.folders:
            files.make_folder(folder)
    for path, old in plan.copy.items():
        files.copy(old, path)
    sent = 0

    def count(part: int) -> None:
        nonlocal sent
        sent += part
        progress(sent, plan.size)

    for path, data in plan.upload.items():
        files.write(path, data, count)
    files.write(manifest + ".new", plan.manifest, lambda part: None)


def _compare(files: BoardFiles, plan: Plan, image: Image) -> None:
    """Read every file of the slot back by its hash, then complete the slot."""
    found = {p: h for p, h in files.survey().files.items() if p.startswith(f"{plan.slot}/")}
    rows: Any = image.manifest["files"]
    wanted = {f"{plan.slot}/{row['file']}": row["sha256"] for row in rows if row["file"] not in ROOT_FILES}
    wanted[f"{plan.slot}/{MANIFEST}.new"] = hashlib.sha256(plan.manifest).hexdigest()
    for path in sorted({*found, *wanted}):
        if found.get(path) != wanted.get(path):
            raise BoardError(
                f"{files.link.port}: {path}: the board reads back something else than was sent: flash again; "
                f"if it stays, its flash is worn out. The old firmware still starts"
            )
    files.rename(f"{plan.slot}/{MANIFEST}.new", f"{plan.slot}/{MANIFEST}")


def _switch(files: BoardFiles, plan: Plan) -> None:
    """Let the slot start next, to be confirmed; a slot confirmed already stays so."""
    if plan.slot != plan.kept:
        files.replace(POINTER, pack_pointer(plan.slot, plan.kept or "-", 0, 0).encode())


def _confirm(link: BoardLink, wish: Wish, plan: Plan, image: Image, outcome: Outcome) -> None:
    """Wait until the new firmware runs, check what it says of itself, confirm it and start it for good."""
    report = _running_report(link, plan)
    outcome.version, outcome.protocol = report["version"], report["protocol"]
    outcome.self_test = "passed" if report["self_test"] == "" else str(report["self_test"])
    if report["build"] != image.manifest["build"]:
        raise BoardError(f"{link.port}: runs build {report['build']}, not {image.manifest['build']}: flash again")
    if report["protocol"] not in (None, image.manifest["protocol"]):
        raise BoardError(f"{link.port}: speaks protocol {report['protocol']}, not {image.manifest['protocol']}")
    if not report["confirmed"]:
        link.run("import slots\nslots.confirm()")
    if wish.node is not None and BoardFiles(link).survey().node is not None:
        raise BoardError(
            f"{link.port}: the joint did not take over id {wish.node}: its stored parameters are broken or its file "
            f"system is full; caramelo joints params restore, then flash again"
        )
    link.reset()


def _running_report(link: BoardLink, plan: Plan) -> dict[str, Any]:
    """Return the report of the wanted slot once its application ran; BoardError when the board went back."""
    report: dict[str, Any] | None = None
    for _ in range(ANSWER_TRIES):
        try:
            report = _report(link)
        except UserError:
            link.close()  # it reset in the middle of an answer
            continue
        ran = report["stage"] in (RUNNING, STOPPED)
        if ran and report["slot"] == plan.slot and report["self_test"] == "":
            return report
        if ran or (report["stage"] == FAILED and report["confirmed"]):
            break
        link.reset()  # stopped on its way, or failed: it starts again, three times at most
    why = _last_line(link)
    _leave_running(link)
    if report is None:
        raise BoardError(f"{link.port}: the board did not come back after its reset: plug it in again")
    raise BoardError(
        f"{link.port}: the new firmware did not start{why}; "
        + (f"the board is back on slot {report['slot']}" if plan.kept else "the board waits for another try")
    )


def _report(link: BoardLink) -> dict[str, Any]:
    heard = bytearray()

    def started(data: bytes) -> bool:
        heard.extend(data)
        return STARTED.encode() in heard

    link.wait_until_back()
    link.listen(SETTLE_S, started)
    link.listen(GRACE_S)
    link.interrupt()
    return link.ask("import json, slots\nprint('@@' + json.dumps(slots.report()))")


def _last_line(link: BoardLink) -> str:
    """Return the last line that tells of a failure in the board's log, with a colon in front."""
    with contextlib.suppress(UserError):
        link.interrupt()
        lines = [line for line in BoardFiles(link).log().splitlines() if "was not confirmed" not in line]
        return f": {lines[-1]}" if lines else ""
    return ""


def _leave_running(link: BoardLink) -> None:
    """Start the board's application again, if the board still answers."""
    with contextlib.suppress(UserError):
        link.interrupt()
        link.reset()
        time.sleep(0.1)
