"""The web process's log: counted and reported in one line, because its screen is the driver's."""

import logging

from aiohttp import ClientPayloadError, web
from aiohttp.http_exceptions import HttpProcessingError

from ...util.console import plain

LONGEST = 200
# Mistakes of the other side: bytes that are not a request, a body that can't be decoded or that breaks off.
THEIRS = (HttpProcessingError, ClientPayloadError, web.RequestPayloadError, UnicodeError, ConnectionError)


class Trouble(logging.Handler):
    """Takes all log entries of this process. Mistakes of the other side are counted, anything else is reported."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.malformed, self._count, self._last = 0, 0, ""
        logging.getLogger().handlers[:] = [self]

    def emit(self, record: logging.LogRecord) -> None:
        """Take one entry."""
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, THEIRS):
            self.malformed += 1
            return
        self._count += 1
        what = record.getMessage() if error is None else f"{type(error).__name__}: {error}"
        self._last = plain(" ".join(what.split()))[:LONGEST]

    @property
    def sentence(self) -> str:
        """The last error, and how many there were; "" if none."""
        return f"{self._count} errors, the last: {self._last}" if self._count else ""
