"""Answers to the questions of a guided procedure: from a person at the terminal, or from a file.

Every question has a key, such as ``servo 5 direction``; a file of answers is a TOML table from keys to texts.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from ....util.console import plain, say
from ....util.errors import UserError
from ....util.files import check_file, read_toml, write_text


class Person(Protocol):
    """Asks and informs. ``there``: a person is at the robot, who can correct what is wrong and try once more."""

    there: bool

    def say(self, text: str) -> None:
        """Show something."""

    def ask(self, key: str, question: str, choices: Sequence[str]) -> str:
        """Return one of ``choices``; without choices any key will do, and "" is returned."""

    def refuse(self, key: str, reason: str) -> None:
        """Say why an answer is refused; the question is asked again."""


def matching(answer: str, choices: Sequence[str]) -> str | None:
    """Return the choice that an answer means, in any case; an unambiguous beginning is enough."""
    wanted = " ".join(answer.lower().split())
    exact = [choice for choice in choices if choice.lower() == wanted]
    close = exact or [choice for choice in choices if wanted and choice.lower().startswith(wanted)]
    return close[0] if len(close) == 1 else None


def enter(prompt: str) -> str:
    """Return a line typed at the terminal."""
    try:
        return input(plain(prompt))
    except EOFError:
        raise UserError("the input ended; what is done so far is kept: run the command again to go on") from None


class AtTerminal:
    """A person at the keyboard. Each answer goes into the file ``record`` at once; older answers stay there.

    UserError if the file is not a file of answers.
    """

    there = True

    def __init__(self, record: Path | None = None) -> None:
        check_file("--record", record)
        self._record = record
        self.answers = read_answers(record) if record is not None and record.exists() else dict[str, str]()

    def say(self, text: str) -> None:
        """See Person."""
        say(text)

    def ask(self, key: str, question: str, choices: Sequence[str]) -> str:
        """See Person; asks until the answer is one of the choices."""
        while True:
            line = enter(f"{question} {'[' + ', '.join(choices) + ']' if choices else '[Enter]'} ")
            answer = "" if not choices else matching(line, choices)
            if answer is not None:
                self._keep(key, answer)
                return answer
            say(f"  {line!r}: answer one of {', '.join(choices)}")

    def _keep(self, key: str, answer: str) -> None:
        self.answers[key] = answer
        if self._record is not None:
            write_answers(self._record, self.answers)

    def refuse(self, key: str, reason: str) -> None:
        """See Person."""
        say(f"  {reason}")


class FromFile:
    """Answers from a file. A missing or refused answer ends the procedure with its key in one line.

    ``hands``: a person turns joints by hand and presses Enter; without it the simulation turns them.
    """

    def __init__(self, answers: dict[str, str], where: str, hands: bool = False) -> None:
        self.answers, self._where, self.there = answers, where, hands

    def say(self, text: str) -> None:
        """See Person; only if a person is there."""
        if self.there:
            say(text)

    def ask(self, key: str, question: str, choices: Sequence[str]) -> str:
        """See Person."""
        if not choices:
            return enter(f"{question} [Enter] ") if self.there else ""
        choices = [choice for choice in choices if choice != "again"]
        if key not in self.answers:
            raise UserError(f"{self._where}: {key}: missing: allowed: {', '.join(choices)}")
        answer = matching(self.answers[key], choices)
        if answer is None:
            raise UserError(f"{self._where}: {key}: value {self.answers[key]!r}: allowed: {', '.join(choices)}")
        self.say(f"{question} {answer}")
        return answer

    def refuse(self, key: str, reason: str) -> None:
        """See Person."""
        raise UserError(f"{self._where}: {key}: {reason}")


def read_answers(path: Path) -> dict[str, str]:
    """Return a file's answers."""
    try:
        table = read_toml(path)
    except OSError as error:
        raise UserError(f"{path}: can't be read: {error.strerror}") from None
    except ValueError as error:
        raise UserError(f"{path}: not TOML: {' '.join(str(error).split())}") from None
    for key, value in table.items():
        if not isinstance(value, str):
            raise UserError(f"{path}: {key}: value {value!r}: allowed: a text in quotes")
    return table


def write_answers(path: Path, answers: dict[str, str]) -> None:
    """Write answers to a file."""
    lines = [f'"{key}" = "{value}"' for key, value in answers.items()]
    write_text(path, "# Answers for --answers.\n" + "\n".join(lines) + "\n")
