"""What one call costs: bytes, with the heap open and locked; time; and marks for a VM that counts its own work.

A function is called by a caller made for its number of arguments, because star arguments and
argument tuples would allocate in the caller.
"""

import gc
import json
import sys

from . import probes

LOOP_US = 500  # a timed loop is to last about so long at most
WARM_UP = 300  # ticks of a walk before it is measured: the robot has stood up
TURNS = 4  # calls of one vector that are counted together; a walk's joints have to follow each of its calls


def _caller(count, head, body, foot):
    """Return ``f(function, values, n)`` that unpacks ``count`` values and runs ``body`` with CALL in it."""
    names = ", ".join([f"a{at}" for at in range(count)])
    lines = ["def caller(f, v, n):"]
    lines.extend([f"    a{at} = v[{at}]" for at in range(count)])
    lines.extend(["    " + line for line in head + body.replace("CALL", f"f({names})").split("\n") + foot])
    space = {"gc": gc}
    exec("\n".join(lines) + "\n", space)
    return space["caller"], space


def _say(answer):
    """Print an answer, bit by bit: in a full memory there is no room for the whole text."""
    sys.stdout.write("@@")
    json.dump(answer, sys.stdout)
    print()


def allocation(module, count):
    """Answer with the most bytes any of ``count`` calls took: by mem_total, by mem_alloc, and if it failed locked."""
    import micropython

    gc.disable()
    rows = []
    for probe in probes(module):
        arity = len(probe.values)
        total, space = _caller(arity, ["before = mem_total()"], "CALL", ["return mem_total() - before"])
        space["mem_total"] = micropython.mem_total
        kept, _ = _caller(arity, ["before = gc.mem_alloc()"], "CALL", ["return gc.mem_alloc() - before"])
        plain, _ = _caller(arity, [], "CALL", [])
        row = [probe.name, probe.ticks, 0, 0, True]
        probe.start()
        turns = count + (WARM_UP if probe.is_walk else 0)
        for index in range(turns):
            probe.draw(index, turns)
            taken = total(probe.function, probe.values, 1)
            row[2] = max(row[2], taken)
            if taken:  # where nothing was taken nothing can be kept, and asking is slow
                row[3] = max(row[3], kept(probe.function, probe.values, 1))
            if probe.ticks and not _runs_locked(micropython, plain, probe):
                row[4] = False
        rows.append(row)
    _say({"rows": rows})


def locked(module, name, count):
    """Answer with the ticks of a walk that ran while the heap was locked, mem_total's move, and how many walked."""
    import micropython

    gc.disable()
    for probe in probes(module):
        if probe.name == name:
            plain, _ = _caller(len(probe.values), [], "CALL", [])
            probe.start()
            ran = moved = walked = 0
            for index in range(count):
                probe.draw(index, count)
                before = micropython.mem_total()
                ran += _runs_locked(micropython, plain, probe)
                moved += micropython.mem_total() - before
                walked += probe.walks()
            _say({"ticks": ran, "bytes": moved, "walked": walked})


def _runs_locked(micropython, caller, probe):
    """Return whether one more call succeeds while the heap is locked."""
    micropython.heap_lock()
    try:
        caller(probe.function, probe.values, 1)
    except MemoryError:
        return False
    finally:
        micropython.heap_unlock()
    return True


def _prepare(probe, count):
    """Start a probe and return the indexes to draw: random vectors, of walks some after standing up."""
    probe.start()
    if probe.is_walk:
        for index in range(WARM_UP):
            probe.draw(index, 0)
            probe.call()
        return range(WARM_UP, WARM_UP + 8 * count)
    return range(count)


def _fill_holes():
    """Fill the heap's holes: a call must not cost more because the search for its frame goes through many."""
    behind = id((0,) * 80)
    filler = ()
    while id(filler) < behind:
        filler = (filler,)


def fuel(module, count):
    """Answer with names, vectors and turns; for each vector marks round an empty loop and calls of so many turns."""
    import host

    rows = []
    for probe in probes(module):
        empty, _ = _caller(len(probe.values), ["for _ in range(n):"], "    pass", [])
        caller, _ = _caller(len(probe.values), ["for _ in range(n):"], "    CALL", [])
        turns = 1 if probe.is_walk else TURNS
        indexes = _prepare(probe, count)
        _fill_holes()
        for index in indexes:
            probe.draw(index, 0)
            host.call("", "")
            empty(probe.function, probe.values, turns)
            host.call("", "")
            caller(probe.function, probe.values, turns)
            host.call("", "")
        rows.append([probe.name, len(indexes), turns])
    _say({"rows": rows})


def instructions(module, names, count):
    """Answer with names and vectors; for each vector six marks, round 4 and 8 turns of an empty loop and calls.

    The difference of 8 and 4 leaves out what entering the loop's function costs; both start from the same state.
    """
    import host

    rows = []
    for probe in probes(module):
        if probe.name in names:
            empty, _ = _caller(len(probe.values), ["for _ in range(n):"], "    pass", [])
            caller, _ = _caller(len(probe.values), ["for _ in range(n):"], "    CALL", [])
            for index in _prepare(probe, count):
                probe.draw(index, 0)
                kept = [list(block) for block in probe.watch]
                for turns in (4, 8):
                    _put_back(probe.watch, kept)
                    host.call("", "")
                    empty(probe.function, probe.values, turns)
                    host.call("", "")
                    caller(probe.function, probe.values, turns)
                    host.call("", "")
            rows.append([probe.name, count])
    _say({"rows": rows})


def _put_back(blocks, kept):
    for block, values in zip(blocks, kept):
        for place in range(len(values)):
            block[place] = values[place]


def clock():
    """Return a function that counts microseconds: of this process where that is told, so that others disturb less."""
    import time

    if hasattr(time, "process_time_ns"):
        return lambda: time.process_time_ns() / 1000
    return time.ticks_us


def _turn(n):
    """The loop that tells how fast a machine is: ``n`` turns of three small operations."""
    x = 0
    for i in range(n):
        x = x * 3 + i & 0xFFFF
    return x


def loop(turns):
    """Answer with the microseconds of ``turns`` turns of the loop above, the best of many."""
    now = clock()
    best = 1 << 28
    for _ in range(100):
        start = now()
        _turn(turns)
        best = min(best, now() - start)
    _say({"us": best})


def timing(module, count, repeats):
    """Answer with microseconds a call of what runs in ticks: the median over vectors, each of them the best loop's.

    A walk goes on with every call: its ticks are timed one by one.
    """
    now = clock()
    rows = []
    for probe in probes(module):
        if not probe.ticks:
            continue
        caller, _ = _caller(len(probe.values), ["for _ in range(n):"], "    CALL", [])
        found = []
        for index in _prepare(probe, count):
            probe.draw(index, 0)
            if probe.is_walk:
                start = now()
                caller(probe.function, probe.values, 1)
                found.append(now() - start)
            else:
                found.append(_best(now, caller, probe.function, probe.values, repeats))
        found.sort()
        rows.append([probe.name, found[len(found) // 2]])
    _say({"rows": rows})


def floats(repeats):
    """Answer with microseconds a call of the float reference's counterparts, the best loop."""
    from float_twin.cases import CASES

    now = clock()
    rows = []
    for name, prepare in CASES:
        function, values = prepare()
        caller, _ = _caller(len(values), ["for _ in range(n):"], "    CALL", [])
        rows.append([name, _best(now, caller, function, values, repeats)])
    _say({"rows": rows})


def _best(now, caller, function, values, repeats):
    """Return microseconds a call in the fastest of at least three loops.

    All loops together make three times ``repeats`` calls. Long ones are made short: fewer are interrupted.
    """
    start = now()
    caller(function, values, 1)
    one = now() - start
    turns = repeats
    while turns > 3 and one * turns > LOOP_US:
        turns //= 2
    best = 1 << 28
    for _ in range(3 * repeats // turns):
        start = now()
        caller(function, values, turns)
        best = min(best, now() - start)
    return best / turns
