"""`caramelo firmware`: builds what a board runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import screen, write_json
from ..errors import NOT_ACHIEVED, UserError
from . import HARDWARE

if TYPE_CHECKING:
    from ..build.image import Image

Role = Annotated[str | None, typer.Option(help="What the board is to be: joint or gait; without it, all modules.")]
RobotName = Annotated[str, typer.Option("--robot", help="Whose data a gait board gets: a name, or a .toml file.")]
Arch = Annotated[str, typer.Option(help="Processor: armv7emsp (STM32F405), armv6m, armv7m, x64, ...")]
Emitter = Annotated[str, typer.Option(help="Code of the marked functions: viper, native or bytecode.")]
Out = Annotated[Path, typer.Option(help="Folder of the tree; a former build there is replaced.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object: the manifest and the sizes.")]
Update = Annotated[bool, typer.Option("--update-budget", help="Take today's sizes as the budget.")]


def register(app: typer.Typer) -> None:
    """Add the group to the command."""
    group = typer.Typer(help="Build what a board runs.", no_args_is_help=True)
    group.command("build")(build)
    app.add_typer(group, name="firmware", rich_help_panel=HARDWARE)


def build(
    role: Role = None,
    arch: Arch = "armv7emsp",
    emitter: Emitter = "viper",
    robot: RobotName = "caramelo",
    out: Out = Path("out/firmware"),
    update_budget: Update = False,
    as_json: Json = False,
) -> int:
    """Compile shared/ and firmware/ for a board. The same sources give the same bytes.

    A module more than 3 % over the size budget in the repository makes the exit code 1.

    Example: caramelo firmware build --role joint --out out/joint
    """
    from ..build.image import write_image
    from ..build.source import BuildError

    _check(role, arch, emitter)
    try:
        image = board_image(role, emitter, arch, robot)
        write_image(image, out)
        sizes, over = _sizes(update_budget)
    except BuildError as error:
        raise UserError(str(error)) from error
    if as_json:
        write_json({"out": str(out), "manifest": image.manifest, "sizes": sizes, "over_budget": over})
    else:
        _print(image, out, sizes, over)
    return NOT_ACHIEVED if over else 0


def _check(role: str | None, arch: str, emitter: str) -> None:
    from ..build.compiler import ARCHES
    from ..build.image import ROLES
    from ..build.rewrite import EMITTERS

    for option, value, allowed in (("--role", role, ROLES), ("--arch", arch, ARCHES), ("--emitter", emitter, EMITTERS)):
        if value is not None and value not in allowed:
            raise UserError(f"{option} {value}: not known; there are {', '.join(allowed)}")


def board_image(role: str | None, emitter: str, arch: str, robot: str) -> "Image":
    """Return the files of a board, what it is and whose included; BuildError or UserError if they can't be had."""
    from ..build.generated import generated_modules
    from ..build.image import build_image
    from ..build.source import PACKAGES, ROOT

    return build_image(ROOT, role, emitter, arch, PACKAGES, generated_modules(role, robot))


def _sizes(update_budget: bool) -> tuple[dict[str, dict[str, int]], list[str]]:
    from ..build.sizes import measure_sizes, over_budget, read_budget, write_budget
    from ..build.source import ROOT

    sizes = measure_sizes(ROOT)
    if update_budget:
        write_budget(sizes)
    return sizes, over_budget(sizes, read_budget())


def _print(image: "Image", out: Path, sizes: dict[str, dict[str, int]], over: list[str]) -> None:
    from rich.table import Table

    manifest: dict[str, Any] = image.manifest
    table = Table("module", "bytecode", "native", "viper", box=None, pad_edge=False)
    for path, row in [*sizes.items(), ("all", _total(sizes))]:
        table.add_row(path, *(str(row[emitter]) for emitter in ("bytecode", "native", "viper")))
    console = screen()
    console.width = max(console.width, 100)
    console.print(table)
    size = sum(len(data) for data in image.files.values())
    console.print(f"(bytes for armv7emsp)\n\n{out}: {len(image.files)} files, {size} bytes")
    protocol = manifest["protocol"]
    console.print(
        f"build {manifest['build']}, {manifest['emitter']} for {manifest['arch']}, mpy {manifest['mpy']}, "
        f"protocol {'none' if protocol is None else f'{protocol:#x}'}"
    )
    for sentence in over:
        console.print(sentence, style="red")


def _total(sizes: dict[str, dict[str, int]]) -> dict[str, int]:
    return {emitter: sum(row[emitter] for row in sizes.values()) for emitter in ("bytecode", "native", "viper")}
