"""Everything that runs on the computer."""

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent  # holds host/, shared/ and firmware/, in a checkout and when installed
