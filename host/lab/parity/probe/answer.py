"""What a runtime is asked, and its answer: one marked line of JSON."""

import json
import sys

from . import MODULES, probes


def _say(answer) -> None:
    print("@@" + json.dumps(answer))


def _find(module, name):
    for probe in probes(module):
        if probe.name == name:
            return probe
    raise ValueError("no probe " + name)


def about() -> None:
    """Answer with the version, the size of a word (found by counting) and the modules."""
    version = ".".join([str(part) for part in sys.implementation.version[:3]])
    bits = 1
    largest = sys.maxsize
    while largest:
        largest >>= 1
        bits += 1
    name = sys.implementation.name
    _say({"implementation": name, "version": version, "word_bits": bits, "modules": MODULES})


def parts() -> None:
    """Answer with what to ask for at once: modules without their walks, and each walk by itself.

    A VM that never collects its garbage starts afresh for each.
    """
    found = []
    for module in MODULES:
        found.append([module, ""])
        found.extend([[module, probe.name] for probe in probes(module) if probe.is_walk])
    _say({"parts": found})


def register(module) -> None:
    """Answer with what is promised about each function of a module; CPython alone knows where one comes from."""
    found = []
    for p in probes(module):
        found.append({"name": p.name, "source": p.function.__module__, "ticks": p.ticks})
    _say({"probes": found})


def parity(module, count, walk="") -> None:
    """Answer with the digest of ``count`` vectors (times the probe's weight) of each function of a module.

    Of its walks only that named ``walk`` is taken, and then nothing else.
    """
    digests = []
    for probe in probes(module):
        if (probe.name if probe.is_walk else "") != walk:
            continue
        total = probe.count(count)
        digests.append([probe.name, total, probe.digest(total, total)])
    _say({"digests": digests})


def prefix(module, name, count, total) -> None:
    """Answer with the digest of the first ``count`` of ``total`` vectors of one function."""
    _say({"digest": _find(module, name).digest(count, total)})


def show(module, name, index, total) -> None:
    """Answer with one vector in full."""
    inputs, result, watched = _find(module, name).show(index, total)
    _say({"inputs": inputs, "result": result, "watched": watched})
