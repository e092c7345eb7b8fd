"""What has to be done to a board so that it holds an image: decided before anything is written."""

import hashlib
import json
from dataclasses import dataclass

from ..build.image import MANIFEST, Image
from ..errors import UserError
from .board_files import ROOT_FILES, Survey

SLOTS = ("a", "b")
MOTOR_OFF_MV = 5500  # USB alone may lift a board's supply to 5 V (assumed); motors run from 12 V up
SPARE_BLOCKS = 4  # for the pointer, the log and what LittleFS needs to move a folder (chosen)
FOLDER_BLOCKS = 2  # LittleFS keeps each folder in a pair of blocks
INLINE = 8  # and files below an eighth of a block in their folder's


@dataclass(frozen=True)
class Plan:
    """The steps of one flashing. Paths are the board's; ``upload`` and ``copy`` fill the slot, ``root`` the top."""

    slot: str
    kept: str
    upload: dict[str, bytes]
    copy: dict[str, str]  # new path -> path on the board with the same content
    stale: tuple[str, ...]  # in the slot, but not in the image
    rewritten: tuple[str, ...]  # in both, with other contents
    stale_folders: tuple[str, ...]
    root: dict[str, bytes]
    manifest: bytes
    same: bool  # the slot holds the image already, whole
    done: bool  # the board runs it, confirmed

    @property
    def size(self) -> int:
        """Bytes that go over the line."""
        return sum(map(len, self.upload.values())) + sum(map(len, self.root.values()))

    @property
    def removed(self) -> list[str]:
        """Files of the slot that go first: stale ones, and those written anew, whose room is needed."""
        return [*self.stale, *self.rewritten]

    @property
    def folders(self) -> list[str]:
        """Folders of the slot, parents first."""
        found: set[str] = {self.slot}
        for path in [*self.upload, *self.copy]:
            parts = path.split("/")
            found |= {"/".join(parts[:count]) for count in range(1, len(parts))}
        return sorted(found)


def make_plan(port: str, image: Image, survey: Survey, slot: str) -> Plan:
    """Decide what goes where; ``slot`` is a, b or auto. UserError if the slot may not be written."""
    slot_files = {path: data for path, data in image.files.items() if path not in ROOT_FILES}
    manifest = (json.dumps(image.manifest) + "\n").encode()
    root = {path: image.files[path] for path in ROOT_FILES if survey.files.get(path) != _sha(image.files[path])}
    kept = survey.kept_slot
    confirmed = survey.pointer is not None and bool(survey.pointer[3])
    if confirmed and slot in ("auto", kept) and _holds(survey, kept, slot_files, manifest):
        return Plan(kept, kept, {}, {}, (), (), (), root, manifest, True, not root)
    target = _target(port, slot, kept)
    upload, copy = {}, {}
    wanted = {f"{target}/{path}": data for path, data in slot_files.items()}
    here = {digest: path for path, digest in survey.files.items() if path.startswith(f"{kept}/")} if kept else {}
    for path, data in wanted.items():
        digest = _sha(data)
        if survey.files.get(path) == digest:
            continue
        if digest in here:
            copy[path] = here[digest]
        else:
            upload[path] = data
    keep = {*wanted, f"{target}/{MANIFEST}"}
    stale = tuple(path for path in sorted(survey.files) if path.startswith(f"{target}/") and path not in keep)
    holding = {path.rsplit("/", count)[0] for path in keep for count in range(1, path.count("/") + 1)}
    empty = tuple(f for f in survey.folders if f.startswith(f"{target}/") and f not in holding)
    same = _holds(survey, target, slot_files, manifest)
    rewritten = tuple(path for path in sorted([*upload, *copy]) if path in survey.files)
    return Plan(target, kept, upload, copy, stale, rewritten, empty, root, manifest, same, False)


def check_board(port: str, image: Image, survey: Survey) -> None:
    """UserError if the image can't run on this board, or if its motor is fed."""
    want = mpy_version(survey.mpy)
    if str(image.manifest["mpy"]) != want:
        raise UserError(
            f"{port}: MicroPython {survey.version} on the board reads mpy {want}, but mpy-cross here makes "
            f"{image.manifest['mpy']}: install the MicroPython that fits (docs/flashing.md)"
        )
    if survey.supply_mV is not None and survey.supply_mV > MOTOR_OFF_MV:
        raise UserError(
            f"{port}: the motor supply is on, {survey.supply_mV / 1000:.1f} V: switch it off, then flash again"
        )


def check_space(port: str, plan: Plan, survey: Survey) -> None:
    """UserError if the plan's files do not fit on the board beside those that stay."""
    need = _blocks(plan, survey) * survey.block
    if need > survey.free:
        raise UserError(
            f"{port}: {need} bytes are needed for a second slot, {survey.free} are free: remove files of your own "
            f"from the board, or give it more storage (docs/flashing.md)"
        )


def mpy_version(word: int) -> str:
    """Return the version of .mpy files from sys.implementation._mpy as mpy-cross writes it."""
    return f"{word & 0xFF}.{word >> 8 & 3}"


def _target(port: str, slot: str, kept: str) -> str:
    if slot == "auto":
        return "b" if kept == "a" else "a"
    if slot == kept:
        raise UserError(f"{port}: slot {slot} holds the firmware that works and is not overwritten: use --slot auto")
    return slot


def _holds(survey: Survey, slot: str, files: dict[str, bytes], manifest: bytes) -> bool:
    """Return True if a slot holds these files and nothing else."""
    wanted = {f"{slot}/{path}": _sha(data) for path, data in {**files, MANIFEST: manifest}.items()}
    return wanted == {path: digest for path, digest in survey.files.items() if path.startswith(f"{slot}/")}


def _blocks(plan: Plan, survey: Survey) -> int:
    """Return the blocks the plan needs beyond those it gives back."""
    new_folders = [folder for folder in plan.folders if folder not in survey.folders]
    sizes = [*map(len, plan.upload.values()), *(survey.sizes[old] for old in plan.copy.values())]
    sizes += [*map(len, plan.root.values()), len(plan.manifest)]
    back = [survey.sizes[path] for path in plan.removed if survey.sizes[path] > survey.block // INLINE]
    need = sum(-(-size // survey.block) for size in sizes) - sum(-(-size // survey.block) for size in back)
    return need + FOLDER_BLOCKS * len(new_folders) + SPARE_BLOCKS


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
