"""Everything that runs on the computer. Installed, it lies below `caramelo`, as shared, sim2d and firmware do."""

from pathlib import Path

NAME = __name__  # "host" in a checkout, "caramelo.host" when installed
ROOT = Path(__file__).resolve().parent.parent  # holds host/, shared/ and firmware/, in a checkout and when installed
