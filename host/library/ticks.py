"""Lets the loop tick: in simulated time the waiting caller does, on hardware a thread of its own.

On hardware the host sends to the joints in every tick, whatever the program is busy with. The thread that ticks does
all requests, between two ticks.
"""

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from math import inf
from typing import Any, TypeVar

from ..control import priority
from ..control.loop import Loop
from .errors import Error, own_words

Answer = TypeVar("Answer")
TICK_MOST_S = 5.0  # a loop that has not ticked for this long hangs, because a bus waits no longer than a tick


class SimulatedTicks:
    """Simulated time, which passes only while a caller waits, as fast as it is computed."""

    came_s = inf  # see control/loop.py, Source

    def __init__(self, loop: Loop, advance: Callable[[float], None]) -> None:
        self._loop, self._advance = loop, advance
        self._alone = threading.RLock()  # a stop may come from another thread

    def start(self) -> None:
        """Begin: functions to call after each tick may be called from now on."""

    def poll(self, timeout_s: float) -> None:
        """See Source: nothing comes from elsewhere."""

    def ticked(self) -> None:
        """End a tick: all its values are known now."""

    def do(self, what: Callable[[], Answer]) -> Answer:
        """Call something between two ticks and return its answer."""
        with self._alone, own_words():
            return what()

    def wait(self) -> None:
        """Return after the next tick; Error if there are no more ticks."""
        with self._alone, own_words():
            self._loop.tick(self)
            self._advance(self._loop.pacer.period_s)

    def close(self) -> None:
        """End the ticks; may be called twice."""


class ThreadTicks:
    """The same for a loop in a thread; ``stop`` is called there if it fails."""

    came_s = inf

    def __init__(self, loop: Loop, stop: Callable[[], None]) -> None:
        self._loop, self._stop = loop, stop
        self._asked: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._ticked = threading.Condition()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="caramelo loop", daemon=True)

    def start(self) -> None:
        """See SimulatedTicks."""
        self._thread.start()

    def _run(self) -> None:
        priority.ask()  # for this thread only
        try:
            self._loop.run(self)
        except BaseException as error:  # the waiting caller gets the error; the joints must not go on without a loop
            self._failure = error
            self._stop()
        self.ticked()

    def poll(self, timeout_s: float) -> None:
        """See Source: do the requests, and wait for them up to a time."""
        try:
            while True:
                what, answer = self._asked.get(timeout=timeout_s) if timeout_s > 0 else self._asked.get_nowait()
                timeout_s = 0.0
                self._answer(what, answer)
        except queue.Empty:
            return

    @staticmethod
    def _answer(what: Callable[[], Any], answer: "Future[Any]") -> None:
        try:
            answer.set_result(what())
        except Exception as error:
            answer.set_exception(error)

    def ticked(self) -> None:
        """See SimulatedTicks; called by the loop's thread."""
        with self._ticked:
            self._ticked.notify_all()

    def do(self, what: Callable[[], Answer]) -> Answer:
        """See SimulatedTicks; Error if the loop has ended or hangs."""
        answer: Future[Answer] = Future()
        self._asked.put((what, answer))
        try:
            with own_words():
                self._check()
                return answer.result(TICK_MOST_S)
        except TimeoutError:
            raise self._gone() from None

    def wait(self) -> None:
        """See SimulatedTicks."""
        with self._ticked:
            ticked = self._thread.is_alive() and self._ticked.wait(TICK_MOST_S)
        self._check()
        if not ticked:
            raise self._gone()

    def _check(self) -> None:
        if not self._thread.is_alive() or self._failure is not None:
            raise self._gone() from self._failure

    def _gone(self) -> Error:
        why = f"has ended: {self._failure}" if self._failure else f"has not ticked for {TICK_MOST_S:g} s"
        return Error(f"the control loop {why}; the joints have been let go")

    def close(self) -> None:
        """See SimulatedTicks."""
        self._loop.end()
        self._asked.put((lambda: None, Future()))  # wakes it up
        if threading.current_thread() is not self._thread:
            self._thread.join(TICK_MOST_S)
