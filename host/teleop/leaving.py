"""Ctrl-C, SIGTERM and a terminal that goes away wake the loop and are counted: once to sit down, twice to let go."""

import signal
import socket
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Self

from ..control.arbiter import Client
from ..control.messages import Message
from ..util.leave import LEAVE_SIGNALS

CHUNK = 64


class Leaving:
    """An input of the hub that only wakes it; ``again`` is called at every signal after the first.

    A SIGHUP that is ignored stays ignored, as nohup needs; Ctrl-C is always heard.
    """

    client = Client("keyboard")

    def __init__(self, again: Callable[[], None]) -> None:
        self.asked = 0
        self._again = again
        self._ours, self._theirs = socket.socketpair()
        self._ours.setblocking(False)
        self._theirs.setblocking(False)

    def fileno(self) -> int:
        """See hub.Input."""
        return self._ours.fileno()

    def messages(self) -> list[Message]:
        """See hub.Input: none; the signal has been counted already."""
        self._ours.recv(CHUNK)
        return []

    def _count(self, number: int, frame: FrameType | None) -> None:
        self.asked += 1
        if self.asked > 1:
            self._again()

    def __enter__(self) -> Self:
        not_ignored = [number for number in LEAVE_SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
        self._before = {number: signal.signal(number, self._count) for number in (signal.SIGINT, *not_ignored)}
        self._woke = signal.set_wakeup_fd(self._theirs.fileno(), warn_on_full_buffer=False)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        signal.set_wakeup_fd(self._woke)
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._ours.close()
        self._theirs.close()
