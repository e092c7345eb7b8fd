"""README and docs are true: every command in them is one, with its options; every file they name is there."""

import ast
import re
import runpy
import shlex
import shutil
import subprocess
import sys

import pytest

from host.cli import build_command
from tests import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
SPAN = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\]\(([^)#:]+)\)")
FILE = re.compile(r"(?<![\w./-])(?:docs|host|shared|sim2d|firmware|tests|examples|caramelo)/[\w./-]*\w")
COMMENT = re.compile(r"(\s{2,}|\s#).*")
QUOTED = re.compile(r'"([^"\n]+)"')
SYMPTOMS = sorted((ROOT / "docs/symptoms").glob("*.md"))
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
    command, at = build_command(), 1
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


def printed() -> list[str]:
    """Return all texts that the program may print: every string of the host's sources, and the page's script."""
    texts = [(ROOT / "host/teleop/web/page/app.js").read_text()]
    for path in (ROOT / "host").rglob("*.py"):
        values = [node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant)]
        texts += [" ".join(value.split()) for value in values if isinstance(value, str)]
    return texts


def not_printed(text, texts):
    """Return the quoted messages of a page, "..." for what differs, that the program never prints."""
    parts = {quote: [part.strip(" ,;:") for part in quote.split("...")] for quote in QUOTED.findall(text)}
    return [quote for quote, words in parts.items() if not all(any(word in each for each in texts) for word in words)]


def test_what_the_pages_of_symptoms_quote_is_what_the_program_prints():
    texts = printed()
    wrong = {page.name: not_printed(page.read_text(), texts) for page in SYMPTOMS}
    assert {name: quotes for name, quotes in wrong.items() if quotes} == {}
    assert sum(len(QUOTED.findall(page.read_text())) for page in SYMPTOMS) > 40
    assert not_printed('| "battery flat: ... V, allowed ..." | |', texts)


@pytest.fixture(scope="module")
def site():
    """Return the pages of the site that are made while it is built."""
    return runpy.run_path(str(ROOT / ".ci/site.py"))["made"]()


def test_the_site_has_every_command_with_every_option(site):
    top = build_command()
    for name, command in top.commands.items():
        page = site[f"commands/{name}.md"]
        for below in getattr(command, "commands", {"": command}).values():
            options = [option for parameter in below.params for option in parameter.opts if option.startswith("--")]
            assert [option for option in options if f"`{option}`" not in page] == []
        assert f"({name}.md)" in site["commands/index.md"]
        assert "``" not in page.replace("```", ""), "an empty default stands there as two ticks"


def test_the_site_tells_of_every_key_what_is_allowed(site):
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \| (.+) \|$", site["robot-keys.md"], re.MULTILINE)
    assert len(rows) > 130
    assert all(allowed and "Input should" not in allowed for _, _, allowed in rows)
    assert ("thigh_m", "L2: thigh joint to knee", "a number within 0.01 .. 1 m") in rows
    assert sum(bool(meaning) for _, meaning, _ in rows) > 0.8 * len(rows)


@pytest.mark.parametrize("broken", [False, True])
def test_the_site_builds_if_no_link_is_broken(tmp_path, broken):
    pytest.importorskip("mkdocs", reason="mkdocs-material is not installed (extra docs)")
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    (tmp_path / ".ci").symlink_to(ROOT / ".ci")
    if broken:
        (tmp_path / "docs/glossary.md").write_text("# Glossary\n\n[gaits](gaits.md#from-nowhere)\n")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", "site"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode != 0) == broken, done.stderr
    assert ("'gaits.md#from-nowhere'" in done.stderr) == broken
    assert broken or (tmp_path / "site/commands/walk.html").exists()


def test_every_page_is_in_the_sites_menu(site):
    menu = (ROOT / "mkdocs.yml").read_text()
    pages = {page.relative_to(ROOT / "docs").as_posix() for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert [page for page in pages if f" {page}\n" not in menu] == []
    assert [page for page in re.findall(r"(\S+\.md)$", menu, re.MULTILINE) if page not in {*pages, *site}] == []
