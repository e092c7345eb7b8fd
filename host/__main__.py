"""Where the command begins: Ctrl-C is heard from the first import on."""

import os
import sys

# Our matrices are small: shared among threads, a decomposition of 300 x 300 took ten times the processor's time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def open_closed_streams() -> None:
    """Give the streams that came closed (``>&-``) a place to go, so that no file gets their descriptors."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115  # it gets the lowest free descriptor


def main() -> int:
    """Run the command of the command line and return its exit code."""
    open_closed_streams()
    try:
        from .cli import main as run

        return run()
    except KeyboardInterrupt:
        sys.stderr.write("caramelo: stopped by Ctrl-C\n")
        return 130  # errors.INTERRUPTED, which may not be imported yet


if __name__ == "__main__":
    sys.exit(main())
