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
    name: Annotated[str | None, typer.Option(help="What it is called; asked for like all that is not given.")] = None,
    front_rear: Annotated[float | None, typer.Option(metavar="M", help="From front to rear hip axes.")] = None,
    left_right: Annotated[float | None, typer.Option(metavar="M", help="From left to right hip axes.")] = None,
    hip_offset: Annotated[float | None, typer.Option(metavar="M", help="Hip axis to the plane of the leg.")] = None,
    thigh: Annotated[float | None, typer.Option(metavar="M", help="Thigh joint to knee.")] = None,
    calf: Annotated[float | None, typer.Option(metavar="M", help="Knee to the middle of the foot.")] = None,
    foot_radius: Annotated[float | None, typer.Option(metavar="M", help="Of the round foot.")] = None,
    knees: Annotated[str | None, typer.Option(help="full-elbow, full-knee, elbow-knee or knee-elbow.")] = None,
    height: Annotated[float | None, typer.Option(metavar="M", help="Hip axis above the foot, standing.")] = None,
    trunk_mass: Annotated[float | None, typer.Option(metavar="KG", help="Body without legs.")] = None,
    hip_mass: Annotated[float | None, typer.Option(metavar="KG", help="One hip, with the thigh's motor.")] = None,
    thigh_mass: Annotated[float | None, typer.Option(metavar="KG", help="One thigh.")] = None,
    calf_mass: Annotated[float | None, typer.Option(metavar="KG", help="One calf with its foot.")] = None,
    calf_motor: Annotated[str | None, typer.Option(help="thigh, or body if a rod drives the calf.")] = None,
    joints: Annotated[str | None, typer.Option(help="A robot with such joints, or other.")] = None,
    model: Annotated[str | None, typer.Option(help="Of other servos: their name.")] = None,
    volts: Annotated[float | None, typer.Option(metavar="V", help="Of other servos: their supply.")] = None,
    stall: Annotated[float | None, typer.Option(metavar="NM", help="Of other servos: stall torque, N m.")] = None,
    rpm: Annotated[float | None, typer.Option(metavar="RPM", help="Of other servos: speed without load.")] = None,
    defaults: Annotated[bool, typer.Option("--defaults", help="Ask nothing: defaults for the rest.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object, as caramelo robots check.")] = False,
) -> int:
    """Write a robot file from answers: lengths, masses and joints. Then it is checked as caramelo robots check does.

    What is not given as an option is asked for, with a default that Enter takes. An answer that can't be is told in
    one line and asked for again. All else in the file follows from the answers, or is that of the robot whose joints
    it has; each line says which.

    Examples: caramelo robots new my.toml; caramelo robots new my.toml --name spot --thigh 0.15 --calf 0.15 --defaults
    """
    from .robots import check_robot

    said = {name: value for name, value in context.params.items() if value is not None}
    given = {name: value for name, value in said.items() if name not in NO_ANSWERS}
    write_new(path, given, defaults, force)
    if not as_json:
        tell_written([path])
    return check_robot(str(path), as_json)


def write_new(path: Path, given: dict[str, Any], defaults: bool, force: bool) -> None:
    """Ask for what is not given, and write the file whole; UserError for what is given wrong."""
    from ..robot.new_robot import new_file, questions
    from ..util.files import write_text

    if path.suffix != ".toml":
        raise UserError(f"{path}: allowed: a file ending in .toml")
    if path.exists() and not force:
        raise UserError(f"{path}: is there already: name another file, or add --force to write over it")
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
    """Return an option's value; its flag stands in front of what is wrong with it."""
    try:
        return question.check(value)
    except UserError as error:
        raise UserError(f"--{str(error).replace('_', '-', question.name.count('_'))}") from None


def _ask(answers: dict[str, "Answer"], former: dict[str, "Answer"], defaults: bool) -> None:
    """Add what is missing; offered is what was said before, or the default."""
    from ..robot.new_robot import unanswered

    while (question := next(unanswered(answers), None)) is not None:
        offer = former.get(question.name, question.default(answers))
        answers[question.name] = question.check(offer) if defaults else _answer(question, offer)


def _answer(question: "Question", offer: "Answer") -> "Answer":
    """Ask until the answer is one that the file may hold."""
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
