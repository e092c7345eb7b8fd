"""Checks that what `make setup-pi` and `make core` install exists as aarch64 or pure wheels: a Pi compiles no package.

Run as ``make pi-wheels`` (needs the network): pip resolves the base dependencies and the extras of a Raspberry Pi
for 64-bit ARM, glibc 2.28 (Raspberry Pi OS 10 and newer), Python 3.11 and 3.13 (Raspberry Pi OS 12 and 13),
without installing anything.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from requirements import requirements

ROOT = Path(__file__).resolve().parent.parent
EXTRAS = ("web", "record", "foxglove", "pi", "compile")
PYTHONS = ("3.11", "3.13")
PLATFORMS = ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64")


def main() -> int:
    wanted = requirements((ROOT / "constraints.txt").read_text(), EXTRAS)
    for python in PYTHONS:
        with tempfile.TemporaryDirectory() as nowhere:
            needed = Path(nowhere, "requirements.txt")
            needed.write_text(wanted)
            command = [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--target", nowhere]
            command += ["--disable-pip-version-check", "--ignore-installed", "--only-binary=:all:"]
            command += [f"--platform={platform}" for platform in PLATFORMS]
            command += ["--python-version", python, "--require-hashes", "--requirement", str(needed)]
            if subprocess.run(command, check=False).returncode:
                print(f"pi-wheels: Python {python}: not all packages have an aarch64 wheel, see above", file=sys.stderr)
                return 1
            print(f"pi-wheels: Python {python}: every package has an aarch64 or a pure wheel")
    return 0


if __name__ == "__main__":
    sys.exit(main())
