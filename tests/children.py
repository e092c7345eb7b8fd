"""Which processes a process has started."""

from pathlib import Path


def children_of(pid):
    """Return the numbers of a process's children, whichever of its threads started them; none if it has ended."""
    found = set()
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        found |= set(task.read_text().split())
    return found
