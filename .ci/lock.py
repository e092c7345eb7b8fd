"""Writes constraints.txt: exact versions and hashes of all dependencies and extras, for every platform, Python >= 3.11.

Run as ``make lock``. Versions already locked are kept where pyproject.toml still allows them; ``--upgrade``
takes the newest. The file holds no address of any package index, so it works with whichever pip is set up for.
"""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "constraints.txt"
HEADER = """\
# Exact version of every package, all extras included, with the hashes of all its files. Written by `make lock` from
# pyproject.toml: do not edit. `make setup` installs what .ci/requirements.py picks from it.
"""


def main() -> int:
    draft = TARGET.with_suffix(".tmp")
    draft.write_text(TARGET.read_text() if TARGET.exists() else "")
    command = [Path(sys.executable).parent / "uv", "pip", "compile", "pyproject.toml", "--output-file", draft]
    command += ["--universal", "--python-version", "3.11", "--all-extras", "--generate-hashes"]
    command += ["--no-header", "--quiet", *sys.argv[1:]]
    done = subprocess.run(command, cwd=ROOT, check=False)
    if done.returncode == 0:
        draft.write_text(HEADER + draft.read_text())
        os.replace(draft, TARGET)
    else:
        draft.unlink()
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
