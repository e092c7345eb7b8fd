"""Prints what `make setup` installs for some extras: the part of constraints.txt that they need, with its hashes.

    python3 .ci/requirements.py web,record,pi

pip takes no hashes from a constraints file, and all of that file would be far too much for a Raspberry Pi. Which
package needs which is in the comments that the lock was written with.
"""

import re
import sys
import tomllib
from collections.abc import Collection
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def canonical(name: str) -> str:
    """Return a package's name as the lock has it; a requirement's extras, version and marker are left out."""
    return re.sub(r"[-_.]+", "-", re.split(r"[^A-Za-z0-9._-]", name.strip())[0]).lower()


def blocks(lock: str) -> list[tuple[str, set[str], str]]:
    """Return name, names of who needs it, and text of every package of the lock."""
    found = []
    for text in re.split(r"\n(?=[A-Za-z0-9])", lock):
        if not text.startswith("#"):
            needed_by = {canonical(line) for line in re.findall(r"(?m)^ +# +(?:via )?([A-Za-z0-9].*)$", text)}
            found.append((canonical(text), needed_by - {"via"}, text.rstrip() + "\n"))
    return found


def wanted(extras: Collection[str]) -> set[str]:
    """Return what pyproject.toml asks for by name: to build it, to run it, and for the extras."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())
    optional = data["project"]["optional-dependencies"]
    unknown = set(extras) - set(optional)
    if unknown:
        raise SystemExit(f"EXTRAS: there is no {', '.join(sorted(unknown))}: there are {', '.join(sorted(optional))}")
    lists = [data["build-system"]["requires"], data["project"]["dependencies"], *(optional[each] for each in extras)]
    return {canonical(line) for lines in lists for line in lines}


def requirements(lock: str, extras: Collection[str]) -> str:
    """Return the lines of the lock for what the extras want, and for what that needs."""
    packages, names = blocks(lock), wanted(extras)
    while more := {name for name, needed_by, _ in packages if needed_by & names} - names:
        names |= more
    return "".join(text for name, _, text in packages if name in names)


if __name__ == "__main__":
    extras = [each for each in sys.argv[1].split(",") if each] if len(sys.argv) > 1 else []
    sys.stdout.write(requirements((ROOT / "constraints.txt").read_text(), extras))
