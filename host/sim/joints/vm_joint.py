"""A simulated joint's inside in a MicroPython VM of its own: the firmware's files, compiled, behind a pipe."""

import json
import os
import select
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from ...util.child import end_child
from ...util.errors import NOT_ACHIEVED, UserError

ANSWER_S = 60.0  # a loaded machine takes long to start a VM; after it there is one millisecond's work at a time
END_S = 5.0
PACKAGE = "host/sim/joints/vm"  # beside the firmware in what the VM runs
EMITTER, ARCH = "viper", "x64"


class VmInside:
    """See vm/inside.py, whose interface this is; UserError when the VM is gone or silent."""

    def __init__(self, unique_id: bytes) -> None:
        self._unique_id = unique_id
        self.bridge = self.q_ref = self.resets = 0
        self.pairs: list[tuple[int, int]] = []
        self._frames: list[tuple[int, bytes]] = []
        self._process: subprocess.Popen[bytes] | None = None

    def _start(self) -> subprocess.Popen[bytes]:
        script = f"from {PACKAGE.replace('/', '.')}.serve import serve; serve()"
        command = [sys.executable, "-m", "micropython_unix", "-X", "heapsize=4M", "-c", script]
        # A session of its own: Ctrl-C in the terminal ends the simulation, not its joints one by one.
        return subprocess.Popen(
            command, cwd=vm_tree(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )

    def boot(self, *arguments: Any) -> None:
        """See Inside."""
        if self._process is None:
            self._process = self._start()
            self._write(list(self._unique_id))
        self._do("boot", *arguments)

    def frame(self, identifier: int, data: bytes, room: int) -> None:
        """See Inside."""
        self._do("frame", identifier, list(data), room)

    def tick(self, *arguments: Any) -> None:
        """See Inside."""
        self._do("tick", *arguments)

    def sent(self) -> list[tuple[int, bytes]]:
        """See Inside."""
        frames, self._frames = self._frames, []
        return frames

    def _do(self, method: str, *arguments: Any) -> None:
        """Have the VM call a method of its Inside, and take what that left."""
        self._write([method, arguments])
        self.bridge, self.q_ref, self.resets, pairs, frames = json.loads(self._read())
        pairs = [(wanted, mask) for wanted, mask in pairs]
        if pairs != self.pairs:
            self.pairs = pairs
        self._frames += [(identifier, bytes(data)) for identifier, data in frames]

    def _write(self, value: Any) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            os.write(self._process.stdin.fileno(), json.dumps(value).encode() + b"\n")
        except OSError as error:
            raise self._gone() from error

    def _read(self) -> bytes:
        """Return the one line that answers a line."""
        assert self._process is not None
        assert self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], ANSWER_S)[0]:
            raise UserError(f"a joint's MicroPython VM has not answered for {ANSWER_S:g} s", NOT_ACHIEVED)
        line = self._process.stdout.readline()
        if not line:
            raise self._gone()
        return line

    def _gone(self) -> UserError:
        assert self._process is not None
        return UserError(f"a joint's MicroPython VM has ended (exit code {self._process.wait()})", NOT_ACHIEVED)

    def close(self) -> None:
        """End the VM; may be called twice."""
        process, self._process = self._process, None
        if process is not None:
            end_child(process, END_S)


@cache
def _built() -> tempfile.TemporaryDirectory[str]:
    """Return a folder, removed when this process ends, with the firmware as the build makes it for the unix VM."""
    from ... import ROOT
    from ...boards.build.source import PACKAGES
    from ...boards.build.tree import compile_tree, write_tree

    folder = tempfile.TemporaryDirectory(prefix="caramelo-vm-")
    write_tree(compile_tree(ROOT, EMITTER, ARCH, (*PACKAGES, PACKAGE)), Path(folder.name) / "tree")
    return folder


def vm_tree() -> Path:
    """Return the folder that the VMs run in; UserError if there is no VM here."""
    from ...boards.runtimes.unix import Unix

    missing = Unix(EMITTER).missing()
    if missing:
        raise UserError(f"joints in MicroPython VMs: {missing}")
    return Path(_built().name) / "tree"
