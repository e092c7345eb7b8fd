"""`make test`: linter, type checker and all tests. All run even when one fails, so that one call shows everything.

Two runs of tests go on at once. Those of the core's sources, and of what is built of them, only compute: they are
shown as they go, and give way to all others. Those only use the core, and run on the compiled one; they wait for
emulated servos and boards for half of their time, and these must not be late. They are shown once both are over.
"""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parent.parent
# The folder whose tests take longest comes first, so that none of them is left over for one core at the end.
OF_SOURCES = ("tests/host/boards/runtimes", "tests/firmware", "tests/shared")
GIVES_WAY = ("nice", "-n", "5")  # a third of the processor time of one that does not
INTERRUPTED = 130  # exit code, as a shell has it
ENDS = (signal.SIGINT, signal.SIGTERM)


def hear() -> None:
    """Take what ends this process, from now on and what has waited."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)


@contextmanager
def started(
    command: Sequence[str], env: Mapping[str, str] | None = None, to: IO[bytes] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command meanwhile, its output shown or ``to`` a file; ended at the latest when the block is left.

    Whoever is ended while it starts a process would never know it.
    """
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDS)
    errors = subprocess.STDOUT if to else None
    try:
        running = subprocess.Popen(command, cwd=ROOT, env=env, stdout=to, stderr=errors, preexec_fn=hear)
    except OSError:
        hear()
        raise
    try:
        hear()
        yield running
    finally:
        running.terminate()
        running.wait()


def with_core(core: str) -> dict[str, str]:
    """Return the environment of tests that run on this core, as CARAMELO_CORE names it."""
    return os.environ | {"CARAMELO_CORE": core}


def run_all(tools: Path, jobs: str) -> list[str]:
    """Run all with what is in the folder ``tools``; return the names of what failed."""
    tests = (f"{tools}/pytest", "-n", jobs, "--dist", "worksteal")
    with tempfile.TemporaryFile() as of_types, tempfile.TemporaryFile() as of_others:
        with started((*GIVES_WAY, f"{tools}/mypy"), to=of_types) as types:
            ruff = subprocess.run((f"{tools}/ruff", "check", "."), cwd=ROOT, check=False).returncode
            with started((*GIVES_WAY, *tests, *OF_SOURCES), with_core("source")) as sources:
                build = (f"{tools}/python", "-m", "tests.core")
                core = subprocess.run(build, cwd=ROOT, stdout=subprocess.PIPE, check=False)
                rest = (*tests, *(f"--ignore={folder}" for folder in OF_SOURCES))
                with started(rest, with_core(core.stdout.decode().strip()), of_others) as others:
                    others.wait()
                sources.wait()
            types.wait()
        for output in (of_others, of_types):
            output.seek(0)
            sys.stdout.write(output.read().decode(errors="replace"))
    codes = {"ruff": ruff, "core": core.returncode, "sources": sources.returncode, "others": others.returncode}
    return [name for name, code in (codes | {"mypy": types.returncode}).items() if code]


def main(tools: str, jobs: str) -> int:
    """Run all; return the exit code."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        failed = run_all(ROOT / tools, jobs)
    except KeyboardInterrupt:
        return INTERRUPTED
    if failed:
        sys.stderr.write(f"make test: failed: {' '.join(failed)}\n")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
