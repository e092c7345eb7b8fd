"""A simulated joint's inside in a MicroPython VM of its own: the firmware's files, compiled, behind a pipe."""

import json
import select
import struct
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ...util.child import end_child
from ...util.errors import NOT_ACHIEVED, UserError
from .vm import messages as m

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
            command, cwd=vm_tree(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        )

    def boot(self, *arguments: Any) -> None:
        """See Inside."""
        self._process = self._process or self._start()
        order = {"unique_id": list(self._unique_id), "arguments": arguments}
        self._ask(m.BOOT, json.dumps(order).encode())

    def frame(self, identifier: int, data: bytes, room: int) -> None:
        """See Inside."""
        self._ask(m.FRAME, struct.pack(m.FRAME_BODY, identifier, len(data), min(room, 255), data))

    def tick(
        self,
        now_us: int,
        sensors: Sequence[int],
        rotors: Sequence[int],
        joint: int,
        raw: Sequence[int],
        room: int,
    ) -> None:
        """See Inside."""
        body = struct.pack(m.TICK_BODY, now_us, *sensors, joint, *raw, min(room, 255), len(rotors))
        self._ask(m.TICK, body + struct.pack(f"<{len(rotors)}H", *rotors))

    def sent(self) -> list[tuple[int, bytes]]:
        """See Inside."""
        frames, self._frames = self._frames, []
        return frames

    def _ask(self, kind: int, body: bytes) -> None:
        process = self._process
        assert process is not None
        assert process.stdin is not None
        try:
            process.stdin.write(struct.pack(m.HEAD, kind, len(body)) + body)
        except OSError as error:
            raise self._gone() from error
        self.bridge, self.resets, self.q_ref, filters, frames = struct.unpack(m.ANSWER, self._read(m.ANSWER_SIZE))
        if filters != m.UNCHANGED:
            packed = self._read(filters * m.FILTER_SIZE)
            self.pairs = list(struct.iter_unpack(m.FILTER, packed))
        if frames:
            for identifier, length, data in struct.iter_unpack(m.SENT, self._read(frames * m.SENT_SIZE)):
                self._frames.append((identifier, data[:length]))

    def _read(self, count: int) -> bytes:
        process = self._process
        assert process is not None
        assert process.stdout is not None
        data = b""
        while len(data) < count:
            if not select.select([process.stdout], [], [], ANSWER_S)[0]:
                raise UserError(f"a joint's MicroPython VM has not answered for {ANSWER_S:g} s", NOT_ACHIEVED)
            part = process.stdout.read(count - len(data))
            if not part:
                raise self._gone()
            data += part
        return data

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
