"""`caramelo robots new`: asks for a robot's lengths, masses and joints, and writes its file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import plain, tell_written, write_error
from ..util.errors import UserError

if TYPE_CHECKING:
    from ..robot.new_robot import Answer, Question

NO_ANSWERS = ("path", "defaults", "force", "as_json")


def new_robot(
    context: typer.Context,
    path: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write, ending in .toml.")],
    name: Annotated[str | None, typer.Option(help="Its name. What no option gives is asked for.")] = None,
    front_rear: Annotated[float | None, typer.Option(metavar="M", help="Distance of front and rear hip axes.")] = None,
    left_right: Annotated[float | None, typer.Option(metavar="M", help="Distance of left and right hip axes.")] = None,
    hip_offset: Annotated[float | None, typer.Option(metavar="M", help="Hip axis to the leg's plane.")] = None,
    thigh: Annotated[float | None, typer.Option(metavar="M", help="Thigh joint to knee.")] = None,
    calf: Annotated[float | None, typer.Option(metavar="M", help="Knee to the middle of the foot.")] = None,
    foot_radius: Annotated[float | None, typer.Option(metavar="M", help="Radius of the round foot.")] = None,
    knees: Annotated[str | None, typer.Option(help="full-elbow, full-knee, elbow-knee, knee-elbow.")] = None,
    height: Annotated[float | None, typer.Option(metavar="M", help="Hip axis above the foot when standing.")] = None,
    trunk_mass: Annotated[float | None, typer.Option(metavar="KG", help="The body without its legs.")] = None,
    hip_mass: Annotated[float | None, typer.Option(metavar="KG", help="One hip, with the thigh's motor.")] = None,
    thigh_mass: Annotated[float | None, typer.Option(metavar="KG", help="One thigh.")] = None,
    calf_mass: Annotated[float | None, typer.Option(metavar="KG", help="One calf with its foot.")] = None,
    calf_motor: Annotated[str | None, typer.Option(help="thigh, or body if a rod drives the calf.")] = None,
    joints: Annotated[str | None, typer.Option(help="A robot that has the same joints, or other.")] = None,
    model: Annotated[str | None, typer.Option(help="Other servos: their name.")] = None,
    volts: Annotated[float | None, typer.Option(metavar="V", help="Other servos: their supply.")] = None,
    stall: Annotated[float | None, typer.Option(metavar="NM", help="Other servos: stall torque, N m.")] = None,
    rpm: Annotated[float | None, typer.Option(metavar="RPM", help="Other servos: no-load speed.")] = None,
    defaults: Annotated[bool, typer.Option("--defaults", help="Ask nothing: take defaults for the rest.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object, as caramelo robots check.")] = False,
) -> int:
    """Write a robot file from your answers on lengths, masses and joints, then check it like caramelo robots check.

    The command asks for each value that no option gives; Enter takes the default. It explains an impossible answer in
    one line and asks again. All other values follow from the answers or are those of the robot that has the same
    joints; each line of the file says which.

    Examples: caramelo robots new my.toml; caramelo robots new my.toml --name spot --thigh 0.15 --calf 0.15 --defaults
    """
    from .robots import check_robot

    said = context.params.items()
    given = {name: value for name, value in said if value is not None and name not in NO_ANSWERS}
    write_new(path, given, defaults, force)
    if not as_json:
        tell_written([path])
    return check_robot(str(path), as_json)


def write_new(path: Path, given: dict[str, Any], defaults: bool, force: bool) -> None:
    """Ask for what no option gives, and write the whole file; UserError for a wrong option."""
    from ..robot.new_robot import new_file, questions
    from ..util.files import check_file, write_text

    if path.suffix != ".toml":
        raise UserError(f"{path}: give a file that ends in .toml")
    if path.exists() and not force:
        raise UserError(f"{path}: the file exists: name another, or overwrite it with --force")
    check_file("FILE", path)
    known = {each.name: each for each in questions()}
    answers = {name: _checked(known[name], value) for name, value in given.items()}
    _ask(answers, {}, defaults)
    while True:
        try:
            text = new_file(answers)
            break
        except UserError as error:
            if defaults or all(each.name in given for each in known.values() if each.asked(answers)):
                raise
            write_error(str(error))
            former, answers = answers, {}
            _ask(answers, former, defaults)
    write_text(path, text)


def _checked(question: "Question", value: object) -> "Answer":
    """Return an option's value; UserError with the option's flag if the value is wrong."""
    try:
        return question.check(value)
    except UserError as error:
        raise UserError(f"--{str(error).replace('_', '-', question.name.count('_'))}") from None


def _ask(answers: dict[str, "Answer"], former: dict[str, "Answer"], defaults: bool) -> None:
    """Add the missing answers; each question offers the earlier answer, or the default."""
    from ..robot.new_robot import unanswered

    while (question := next(unanswered(answers), None)) is not None:
        offer = former.get(question.name, question.default(answers))
        answers[question.name] = question.check(offer) if defaults else _answer(question, offer)


def _answer(question: "Question", offer: "Answer") -> "Answer":
    """Ask until the file may hold the answer."""
    if question.name == "joints":
        _tell_joints()
    while True:
        said = typer.prompt(question.text, default=str(offer), err=True)
        try:
            return question.check(said)
        except UserError as error:
            typer.echo(plain(str(error)), err=True)


def _tell_joints() -> None:
    from ..robot.new_robot import joints_like

    for name, what in joints_like().items():
        typer.echo(f"  {name:<14} {plain(what)}", err=True)
