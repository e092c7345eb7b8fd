"""Which lines of shared/ run: needs a MicroPython with ``sys.settrace``. Import before anything of shared."""

import sys

LINES = {}


def _follow(frame, event, argument):
    name = frame.f_code.co_filename
    at = name.find("shared/")
    if at < 0:
        return None
    if event == "line":
        LINES.setdefault(name[at:], set()).add(frame.f_lineno)
    return _follow


def lines(count):
    """Answer with the lines of shared/ that ran while every probe ran ``count`` vectors."""
    import json

    sys.settrace(_follow)
    from . import MODULES, probes

    for module in MODULES:
        for probe in probes(module):
            total = probe.count(24 if probe.is_walk else count)
            probe.digest(total, total)
    sys.settrace(None)
    print("@@" + json.dumps({"lines": {name: sorted(numbers) for name, numbers in LINES.items()}}))
