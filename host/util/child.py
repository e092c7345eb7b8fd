"""Ends the processes that this one started."""

import subprocess
from typing import Any


def end_child(process: subprocess.Popen[Any], patience_s: float) -> None:
    """Close its input, which makes it end; kill it if it still runs ``patience_s`` later; close its output."""
    if process.stdin is not None:
        process.stdin.close()
    try:
        process.wait(patience_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()
