"""Ends a drive's listeners all at once, each in a thread of its own, within a common time limit.

By then the joints have been let go. A disk, a page or a terminal that hangs is left behind, so the program ends.
"""

import threading
import time
from collections.abc import Callable, Mapping


def end_all(closers: Mapping[str, Callable[[], object]], within_s: float) -> list[str]:
    """Call all; return the names of those that have not ended in time. An error of one is raised at the end."""
    errors: list[Exception] = []

    def end(close: Callable[[], object]) -> None:
        try:
            close()
        except Exception as error:
            errors.append(error)

    threads = {
        name: threading.Thread(target=end, args=(close,), name=f"end {name}", daemon=True)
        for name, close in closers.items()
    }
    for thread in threads.values():
        thread.start()
    end_s = time.monotonic() + within_s
    for thread in threads.values():
        thread.join(max(0.0, end_s - time.monotonic()))
    if errors:
        raise errors[0]
    return [name for name, thread in threads.items() if thread.is_alive()]
