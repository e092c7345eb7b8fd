"""The loader's own decision, compiled for this machine and called on simulated flash."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from host import ROOT

from .sim_flash import PowerCut

SOURCES = ROOT / "firmware/loader"
PROGRAM = ctypes.CFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32)


@functools.cache
def _library():
    folder = tempfile.mkdtemp(prefix="caramelo-loader-")
    target = Path(folder, "choose.so")
    warnings = ["-Wall", "-Wextra", "-Werror"]
    source = str(SOURCES / "choose.c")
    subprocess.run(["cc", "-O1", "-std=c11", *warnings, "-shared", "-fPIC", "-o", str(target), source], check=True)
    library = ctypes.CDLL(str(target))
    shutil.rmtree(folder)
    return library


def choose(flash):
    """Return the slot that the loader starts, -1 for none. It writes through ``flash``, cuts included."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: sudo apt-get install gcc")
    cell = (ctypes.c_uint8 * len(flash.store.data)).from_buffer(flash.store.data)
    cut = []

    def program(at, word):
        if cut:
            return
        try:
            flash.program(at, word.to_bytes(4, "little"))
        except PowerCut as error:
            cut.append(error)
        except OSError:
            pass  # the loader reads back by itself

    slot = _library().choose_slot(cell, PROGRAM(program))
    del cell
    if cut:
        raise cut[0]
    return slot
