"""Runs a command with a time limit and turns a failure into one exception."""

import subprocess
from pathlib import Path

from .base import RuntimeFailure


def run_command(command: list[str], folder: Path, timeout_s: float, name: str) -> str:
    """Return the output of ``command`` in ``folder``; RuntimeFailure if it fails or takes too long."""
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=timeout_s, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired as error:
        raise RuntimeFailure(f"{name}: no answer within {timeout_s:g} s") from error
    if done.returncode:
        raise RuntimeFailure(f"{name}: exit {done.returncode}: {(done.stderr or done.stdout).strip()[-2000:]}")
    return done.stdout
