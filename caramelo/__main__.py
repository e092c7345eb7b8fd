"""The command `caramelo`, also as `python -m caramelo`."""

import sys

from host.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
