"""Pages of the documentation site that are made while it is built: make docs.

The first page and those of the repository's root come from their files; the commands from their own help; the keys of a
robot file from its checker, which says of each what is allowed.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
FROM_ROOT = {"index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changes.md": "CHANGELOG.md"}
EXAMPLES = ("caramelo", "parallel", "solo12")  # a key's example is that of the first that has it
GAIT = "examples/amble.toml"  # of a gait of one's own

COMMANDS = """# Commands

The texts are those of `caramelo COMMAND --help`. Exit codes: 0 done, 1 not achieved, 2 wrong use or bad input, 130
stopped by Ctrl-C. With `--json` a command prints exactly one object.

| command | does |
|---|---|"""
KEYS = """# Keys of a robot file

The meaning of each key comes from a robot's own file, the allowed values from its checker.
[Robot files](robot-files.md) explains the tables and the conventions.
"""


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that no file in docs/ holds (an event of mkdocs)."""
    from mkdocs.structure.files import File

    for path, text in made().items():
        files.append(File.generated(config, path, content=text))
    return files


def on_config(config: Any) -> Any:
    """Give each command its place in the menu (an event of mkdocs)."""
    commands = [{name: f"commands/{name}.md"} for name in sorted(command_pages()) if name != "index"]
    for section in config.nav:
        for entry in section.get("Reference", []) if isinstance(section.get("Reference"), list) else []:
            if entry.get("Commands") == "commands/index.md":
                entry["Commands"] = ["commands/index.md", *commands]
    return config


def made() -> dict[str, str]:
    """Return the pages by their paths in the site."""
    pages = {path: from_root((ROOT / name).read_text()) for path, name in FROM_ROOT.items()}
    pages |= {f"commands/{name}.md": text for name, text in command_pages().items()}
    return pages | {"robot-keys.md": keys_page()}


def from_root(text: str) -> str:
    """Return a page of the repository's root with its links as seen from docs/."""
    for path, name in FROM_ROOT.items():
        text = text.replace(f"]({name})", f"]({path})")
    return text.replace("](docs/", "](")


def command_pages() -> dict[str, str]:
    """Return a page for each command or group, and ``index``."""
    from host.cli import build_command

    top = build_command()
    pages = {name: f"# caramelo {name}\n\n" + "\n".join(sections(command, f"caramelo {name}"))
             for name, command in top.commands.items()}  # fmt: skip
    rows = [f"| [`caramelo {name}`]({name}.md) | {first(command)} |" for name, command in sorted(top.commands.items())]
    return pages | {"index": "\n".join([COMMANDS, *rows, ""])}


def first(command: Any) -> str:
    """Return the first sentence of a command's help."""
    return cell(re.split(r"(?<=\.)\s", command.help.strip(), maxsplit=1)[0])


def sections(command: Any, name: str) -> Iterator[str]:
    """Yield the lines of a command's section, those of its own commands after it."""
    text, _, examples = re.sub(r"(?m)^[ \t]+", "", command.help).partition("Example")
    yield text + "\n"
    if getattr(command, "commands", None):
        for below, one in sorted(command.commands.items()):
            yield f"## {name} {below}\n"
            yield from sections(one, f"{name} {below}")
        return
    arguments = [usage(each) for each in command.params if not each.opts[0].startswith("-")]
    yield f"    {' '.join([name, *arguments])} [options]"
    yield from (f"    {each}" for each in " ".join(examples.partition(": ")[2].split()).split("; "))
    yield ""
    yield "| argument, option | | without it |\n|---|---|---|"
    for each in command.params:
        words = f"`{'`, `'.join((*each.opts, *each.secondary_opts))}`" if each.opts[0][0] == "-" else usage(each)
        yield f"| {words} | {cell(each.help or '')} | {without(each)} |"
    yield ""


def usage(argument: Any) -> str:
    """Return how an argument stands in a command's usage."""
    name = argument.metavar or argument.name.upper()
    return name if argument.required else f"[{name}]"


def without(parameter: Any) -> str:
    """Return what holds without a parameter, as Markdown."""
    value = parameter.default
    if parameter.required:
        return "needed"
    if value is None or value is False or value == "" or callable(value):
        return ""
    return f"`{'yes' if value is True else value}`"


def cell(text: str) -> str:
    """Return a text for a table's cell."""
    return " ".join(text.split()).replace("|", "\\|").replace("[bold]", "").replace("[/]", "")


def keys_page() -> str:
    """Return every key of a robot file: what it is, what is allowed."""
    from host.robot.model import Robot

    tables: dict[str, list[str]] = {}
    comments = [comments_of((ROOT / f"host/robot/files/{name}.toml").read_text()) for name in EXAMPLES]
    comments.append({f"gait.own.{key}": told for key, told in comments_of((ROOT / GAIT).read_text()).items()})
    for path, allowed, needed in keys(Robot):
        table, _, key = path.rpartition(".")
        meaning = next((told[path] for told in comments if path in told), "")
        row = f"| `{key}` | {cell(meaning)} | {cell(allowed)}{'' if needed else '; may be left out'} |"
        tables.setdefault(table, []).append(row)
    lines = [KEYS]
    for table, rows in tables.items():
        lines += [f"## {f'[{table}]' if table else 'Top'}\n\n| key | meaning | allowed |\n|---|---|---|", *rows, ""]
    return "\n".join(lines)


def keys(model: Any, above: str = "") -> Iterator[tuple[str, str, bool]]:
    """Yield (path, what is allowed, whether it is needed) of each key of a table and of those in it."""
    from typing import get_args

    from host.robot.values import Table

    for name, field in model.model_fields.items():
        parts = [field.annotation, *get_args(field.annotation)]
        parts += [inner for part in parts for inner in get_args(part)]
        inside = dict.fromkeys(part for part in parts if isinstance(part, type) and issubclass(part, Table))
        for part in inside:
            kind = getattr(part.model_fields.get("kind"), "annotation", None) if len(inside) > 1 else None
            yield from keys(part, f"{above}{name}{f' ({get_args(kind)[0]})' if kind else ''}.")
        if not inside:
            yield above + name, allowed_by(field), field.is_required()


def allowed_by(field: Any) -> str:
    """Return what a key's checker allows, in the checker's own words: it is asked with a value that can't be."""
    from typing import Annotated, Literal, get_args, get_origin

    from pydantic import TypeAdapter, ValidationError

    kind = field.annotation
    if get_origin(kind) is Literal:
        return " or ".join(f'"{each}"' for each in get_args(kind))
    if not field.metadata:
        return "a table: see [robot files](robot-files.md#tables)"
    for each in field.metadata:
        kind = Annotated[kind, each]
    try:
        TypeAdapter(kind).validate_python(object())
    except ValidationError as error:
        return error.errors()[0]["msg"]
    return ""


def comments_of(text: str) -> dict[str, str]:
    """Return the meanings that stand behind a file's lines, by key; the kind of a joint or bus is in the path."""
    import tomllib

    kinds = {name: table["kind"] for name, table in tomllib.loads(text).items()
             if isinstance(table, dict) and "kind" in table}  # fmt: skip
    found, table = {}, ""
    for line in text.splitlines():
        if head := re.match(r"\[+([\w.]+)\]", line):
            names = head[1].split(".")
            table = ".".join((f"{names[0]} ({kinds[names[0]]})" if names[0] in kinds else names[0], *names[1:])) + "."
        elif row := re.match(r"(\w+) *=.*?#\s*\[.*?\]\s*(.*?)\s*(\([^()]*\))?$", line):
            found[table + row[1]] = row[2]
    return found
