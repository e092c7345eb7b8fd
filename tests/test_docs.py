"""README and docs are true: every command in them is one, with its options; every file they name is there."""

import re
import shlex

import pytest
import typer

from host.cli import build_app
from tests import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
SPAN = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\]\(([^)#:]+)\)")
FILE = re.compile(r"(?<![\w./-])(?:docs|host|shared|sim2d|firmware|tests|examples|caramelo)/[\w./-]*\w")
COMMENT = re.compile(r"(\s{2,}|\s#).*")
MADE = ("host/robot/files/my.toml",)


def commands(text):
    """Yield the caramelo and make commands of a page: lines of its code blocks, and spans in its text."""
    lines = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    for candidate in lines + [span for line in text.splitlines() for span in SPAN.findall(line)]:
        shown = COMMENT.sub("", candidate).removeprefix("sudo ").removeprefix(".venv/bin/")
        if shown.startswith(("caramelo ", "make ")):
            yield shown


def complaint(shown):
    """Return what is wrong with a command, '' if nothing is. It is parsed as when it is run, but not run."""
    words = shlex.split(shown.replace("...", "").replace("|", " "))
    if words[0] == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
        return "" if words[1] in targets else f"make has no target {words[1]}"
    command, at = typer.main.get_command(build_app()), 1
    while at < len(words) and words[at] in getattr(command, "commands", {}):
        command, at = command.commands[words[at]], at + 1
    if getattr(command, "commands", None) and at < len(words) and not words[at].startswith(("-", "[")):
        return f"{' '.join(words[:at])} has no command {words[at]}"
    known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    for word in words[at:]:
        option = word.partition("=")[0].strip("[]")
        if option.startswith("--") and option not in {*known, "--help"}:
            return f"{' '.join(words[:at])} has no option {option}"
    return ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_is_one(page):
    wrong = [f"{shown}: {complaint(shown)}" for shown in commands(page.read_text()) if complaint(shown)]
    assert wrong == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_named_is_there(page):
    text = page.read_text()
    linked = [page.parent / name for name in LINK.findall(text)]
    named = [ROOT / name for name in FILE.findall(text) if name not in MADE]
    assert [str(path) for path in linked + named if not path.exists()] == []


def test_most_pages_show_commands():
    assert sum(1 for page in PAGES if list(commands(page.read_text()))) > len(PAGES) / 2


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        ("caramelo wlak --speed 0.1", "has no command wlak"),
        ("caramelo walk --sped 0.1", "caramelo walk has no option --sped"),
        ("caramelo firmware image --roles gait", "caramelo firmware image has no option --roles"),
        ("make demos", "make has no target demos"),
        ("caramelo walk --speed 0.1 --out out/x", ""),
    ],
)
def test_a_wrong_command_is_found(shown, words):
    assert complaint(shown).endswith(words)
    assert bool(complaint(shown)) == bool(words)
