"""`caramelo firmware`: builds the firmware of the boards."""

import os
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import print_table, progress, screen, write_json, write_note
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.files import check_folder, write_bytes, write_text
from ._options import Json

if TYPE_CHECKING:
    from ..boards.build.board_image import Built
    from ..boards.build.image_budget import Row
    from ..lab.parity.paths import RoleFigures

Sources = Annotated[Path, typer.Option("--micropython", help="MicroPython's sources: a checkout with its submodules.")]
Role = Annotated[str | None, typer.Option(help="The board's role: joint or gait (default: both).")]
RobotName = Annotated[str, typer.Option("--robot", help="Robot whose data a gait board gets: a name, or a .toml file.")]
Out = Annotated[Path, typer.Option(help="Folder for the images; builds go on in its build/.")]
Jobs = Annotated[int | None, typer.Option(min=1, help="Files compiled at once (default: one per processor).")]
Minutes = Annotated[int, typer.Option(min=0, max=600, metavar="M", help="Also let it operate for this long.")]

GROUP = typer.Typer(help="Build the firmware of the boards.", no_args_is_help=True)


@GROUP.command()
def image(
    micropython: Sources,
    role: Role = None,
    robot: RobotName = "caramelo",
    out: Out = Path("out/firmware"),
    jobs: Jobs = None,
    as_json: Json = False,
) -> int:
    """Build the complete image of a board from MicroPython's sources, and print how much of the chip it takes.

    Writes ROLE.caramelo for `caramelo flash`, and ROLE.dfu and ROLE.hex for a bare board. Needs ARM's compiler. Exit
    code 1 if the image takes more than host/boards/build/image_budget.json allows.

    Example: caramelo firmware image --micropython ~/micropython --role joint
    """
    from ..boards.build.image_budget import over_budget, rows

    roles = _roles(role)
    check_folder("--out", out)
    told, over = {}, []
    for name in roles:
        built = _build(name, robot, micropython, out, jobs or os.cpu_count() or 1)
        table = rows(name, built.bytes)
        over += over_budget(name, table)
        told[name] = {"build": built.image.about.build, "bytes": built.bytes}
        if not as_json:
            _print(name, built, table, out)
    if as_json:
        write_json({"out": str(out), "images": told, "over_budget": over})
    else:
        for sentence in over:
            screen().print(sentence, style="red", soft_wrap=True)
    return NOT_ACHIEVED if over else 0


@GROUP.command()
def measure(
    micropython: Sources, role: Role = None, minutes: Minutes = 0, jobs: Jobs = None, as_json: Json = False
) -> int:
    """Count the instructions of whole paths of the firmware on an emulated Cortex-M4, and the heap that they leave.

    Builds MicroPython's qemu port with the firmware frozen in and runs it against the model of the chip. Needs ARM's
    compiler and the extra `emulator`. Exit code 1 if a path costs more than host/lab/parity/path_budget.json allows, or
    if --minutes of operation take a byte of the chip's heap. On a computer these minutes take as long as on a board
    for the joint, and a tenth of that for the gait board.

    Examples: caramelo firmware measure --micropython ~/micropython --role joint;
    caramelo firmware measure --micropython ~/micropython --minutes 60
    """
    from ..boards.runtimes.base import RuntimeFailure
    from ..lab.parity.paths import HEAP_BYTES, figures_of

    told, ok = {}, True
    for name in _roles(role):
        write_note(f"{name}: building, then counting; this takes some minutes")
        try:
            figures = figures_of(name, micropython, jobs or os.cpu_count() or 1, minutes)
        except RuntimeFailure as error:
            raise UserError(str(error), NOT_ACHIEVED) from error
        ok = ok and figures.ok
        told[name] = figures.told()
        if not as_json:
            _print_paths(name, figures, HEAP_BYTES)
            if minutes and not figures.complaints:
                screen().print(f"{minutes} minutes of operation took 0 bytes of the heap", soft_wrap=True)
    if as_json:
        write_json({"ok": ok, "heap_bytes": HEAP_BYTES, "roles": told})
    return 0 if ok else NOT_ACHIEVED


def _print_paths(role: str, figures: "RoleFigures", heap_bytes: int) -> None:
    print_table((f"{role}, instructions", "median", "most", "at most", ""), [
        (path.name, path.median, path.most, path.budget, "" if path.ok else "over budget") for path in figures.paths])
    console = screen()
    free = f"heap of {heap_bytes} bytes: {figures.free} free after set-up, {figures.left} after the run"
    console.print(free + f", at least {figures.least_free} wanted", soft_wrap=True)
    for sentence in figures.complaints:
        console.print(sentence, style="red", soft_wrap=True)


def _roles(role: str | None) -> list[str]:
    from ..boards.build.frozen import ROLES

    if role is not None and role not in ROLES:
        raise UserError(f"--role {role}: allowed {', '.join(ROLES)}")
    return [role] if role else list(ROLES)


def _build(role: str, robot: str, micropython: Path, out: Path, jobs: int) -> "Built":
    from ..boards.build.board_image import COMPILED_FILES, build_board_image
    from ..boards.build.dfu import dfu_file, hex_file
    from ..boards.build.image_file import write_image_file
    from ..boards.build.source import BuildError

    done = count(1)
    with progress(f"{role}: building", COMPILED_FILES) as advance:
        try:
            built = build_board_image(role, robot, micropython, out / "build" / role, jobs,
                                      lambda: advance(min(next(done), COMPILED_FILES)))
        except BuildError as error:
            raise UserError(str(error)) from error
    write_image_file(built.image, out / f"{role}.caramelo")
    write_bytes(out / f"{role}.dfu", dfu_file(built.image))
    write_text(out / f"{role}.hex", hex_file(built.image))
    return built


def _print(role: str, built: "Built", table: "list[Row]", out: Path) -> None:
    about = built.image.about
    console = screen()
    console.soft_wrap = True
    console.print(
        f"{out / role}.caramelo: {about.board}, version {about.version}, build {about.build}, "
        f"MicroPython {about.micropython}; for a bare board {role}.dfu and {role}.hex"
    )
    print_table(("memory", "what", "bytes", "budget", "room"), [
        (row.memory, row.what, row.bytes, f"{'>=' if row.least else '<='} {row.budget}", row.room) for row in table])
