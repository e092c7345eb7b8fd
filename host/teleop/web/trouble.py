"""What the web process logs: counted and told in a line, for its screen is the driver's."""

import logging

from aiohttp import ClientPayloadError, web
from aiohttp.http_exceptions import HttpProcessingError

from ...util.console import plain

LONGEST = 200
# What the other side does wrong: bytes that are no request, a body that can't be decoded or that breaks off.
THEIRS = (HttpProcessingError, ClientPayloadError, web.RequestPayloadError, UnicodeError, ConnectionError)


class Trouble(logging.Handler):
    """Takes all that is logged in this process. What the other side does wrong is counted, anything else is told."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.malformed, self._count, self._last = 0, 0, ""
        logging.getLogger().handlers[:] = [self]

    def emit(self, record: logging.LogRecord) -> None:
        """Take one."""
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, THEIRS):
            self.malformed += 1
            return
        self._count += 1
        what = record.getMessage() if error is None else f"{type(error).__name__}: {error}"
        self._last = plain(" ".join(what.split()))[:LONGEST]

    @property
    def sentence(self) -> str:
        """What went wrong last, and how often something did; "" if nothing."""
        return f"{self._count} errors, the last: {self._last}" if self._count else ""
