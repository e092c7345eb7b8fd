"""The loop: listens to all command sources until the next tick, then senses, listens again and acts.

It takes commands between reading the joints and planning, so one that arrives while the joints answer still makes it
into this tick. A stop does not wait for a tick at all. The loop never waits for what a message asks: it is done in the
ticks to come.
"""

import gc
import time
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any, Protocol

from .arbiter import Client
from .messages import Message
from .pacer import Pacer, figures_ms
from .supervisor import Supervisor

KEPT = 2000


class Source(Protocol):
    """A source of commands."""

    came_s: float  # since when the present input may have been waiting, by the loop's clock; inf: it has not

    def poll(self, timeout_s: float) -> None:
        """Wait for input up to a time and pass it to the loop."""


class Loop:
    """Ticks of one supervisor. ``after_tick`` is called with the loop after each."""

    def __init__(
        self,
        supervisor: Supervisor,
        after_tick: Callable[["Loop"], None] = lambda loop: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.supervisor, self._after_tick, self.clock = supervisor, after_tick, clock
        self.pacer = Pacer(supervisor.driver.rate_hz, clock())
        self.running = True
        self._source: Source | None = None
        # By source: time from the sender's time stamp to the packet on the bus, s, by the wall clock; only if both use
        # the same clock. Without a stamp a stop's time counts from when its source was last seen without input.
        self.command_s: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=KEPT))
        self.stop_s: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=KEPT))
        # When the bus last got goals after the sticks had moved, and a stop; None: never.
        self.steered_at_s: float | None = None
        self.stopped_at_s: float | None = None

    def receive(self, client: Client, message: Message) -> bool:
        """Take a checked message; a stop acts at once."""
        supervisor, now_s = self.supervisor, self.clock()
        first = supervisor.arbiter.stop is None
        obeyed = supervisor.arbiter.handle(client, message, now_s)
        if message["type"] == "stop" and first:
            supervisor.stop_now()
            waited_s = min(now_s, self._source.came_s) if self._source is not None else now_s
            self._clock_stop(client, message.get("t_ms"), waited_s)
        elif message["type"] == "reset" and obeyed:
            supervisor.reset()
        return obeyed

    def end(self) -> None:
        """End before anything more is sent to the joints; a signal handler may call it."""
        self.running = False

    def drop(self, client: Client) -> None:
        """A client is gone."""
        self.supervisor.arbiter.drop(client)

    def run(self, source: Source) -> None:
        """Tick until ``running`` is false."""
        gc.collect()
        gc.freeze()
        self.pacer = Pacer(self.supervisor.driver.rate_hz, self.clock())
        try:
            while self.running:
                self._wait(source)
                if self.running:
                    self.tick(source)
        finally:
            gc.unfreeze()

    def _wait(self, source: Source) -> None:
        while self.running and (left_s := self.pacer.due_s - self.clock()) > 0:
            source.poll(left_s)

    def tick(self, source: Source) -> None:
        """One tick: sense, listen, act."""
        self._source = source
        self.pacer.begin(self.clock())
        self.supervisor.sense()
        source.poll(0.0)
        if not self.running:
            return
        self.supervisor.act(self.clock())
        self._clock_command()
        self.pacer.end(self.clock())
        self._after_tick(self)

    def _clock_command(self) -> None:
        """Note how long the newest stick command took from its sender to the bus."""
        arbiter = self.supervisor.arbiter
        pending, arbiter.pending = arbiter.pending, None
        if pending is None or not self.supervisor.armed:
            return
        if pending.moved:
            self.steered_at_s = self.clock()
        if pending.t_ms is not None:
            self.command_s[pending.source].append(time.time() - pending.t_ms / 1000)

    def _clock_stop(self, client: Client, t_ms: float | None, came_s: float) -> None:
        self.stopped_at_s = self.clock()
        taken_s = self.stopped_at_s - came_s if t_ms is None else time.time() - t_ms / 1000
        self.stop_s[client.source].append(taken_s)

    def timing(self) -> dict[str, Any]:
        """Return the ticks' figures, and how long commands and stops took to reach the bus, ms."""
        return {
            "rate_hz": self.supervisor.driver.rate_hz,
            **self.pacer.summary(),
            "command_to_packet_ms": {source: figures_ms(seconds) for source, seconds in self.command_s.items()},
            "stop_to_packet_ms": {source: figures_ms(seconds) for source, seconds in self.stop_s.items()},
        }
