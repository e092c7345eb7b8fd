"""MicroPython's unix port, 64 bit: the one that runs native and viper code on a PC."""

import platform
import sys
from pathlib import Path

from ...util.extras import not_installed
from .base import Runtime, run_command


class Unix(Runtime):
    """``emitter`` source runs the files as they are, the others run them as converted by the firmware build."""

    timeout_s = 1000.0  # for all scripts at once
    afresh = False
    arch = "x64"

    def __init__(self, emitter: str) -> None:
        self.emitter = emitter
        self.name = f"unix-{emitter}"

    def missing(self) -> str | None:
        if (sys.platform, platform.machine()) != ("linux", "x86_64"):
            return f"the unix VM exists only for linux x86_64, this is {sys.platform} {platform.machine()}"
        return not_installed("micropython_unix")

    def execute(self, tree: Path, script: str) -> str:
        command = [sys.executable, "-m", "micropython_unix", "-X", "heapsize=4M", "-c", script]
        return run_command(command, tree, self.timeout_s, self.name)
