"""Who may use the page: its own origin only, and beyond this machine only who knows the code from the terminal."""

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Callable
from urllib.parse import urlsplit

CODE_DIGITS = 6
# One guess a second, and a minute's rest after five: 10^6 codes are out of reach.
GUESSES, REST_S, BETWEEN_S = 5, 60.0, 1.0
MOST_TOKENS = 32


def new_code() -> str:
    """Return a fresh pairing code."""
    return f"{secrets.randbelow(10**CODE_DIGITS):0{CODE_DIGITS}d}"


def is_loopback(address: str) -> bool:
    """True if only this machine can reach a listener at the address."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"


class Pairing:
    """Trades the code for a token. ``code`` "" lets everybody in: the listener is this machine's own."""

    def __init__(self, code: str, clock: Callable[[], float]) -> None:
        self._code, self._clock = code, clock
        self._tokens: list[str] = []
        self._wrong = 0
        self._closed_until_s = 0.0

    def allows(self, token: str | None) -> bool:
        """True for a paired browser."""
        if not self._code:
            return True
        return token is not None and any(hmac.compare_digest(token.encode(), t.encode()) for t in self._tokens)

    def pair(self, code: str) -> str | None:
        """Return a token for the right code; None for a wrong one, or while guessing rests."""
        now_s = self._clock()
        if now_s < self._closed_until_s:
            return None
        if not hmac.compare_digest(code.encode(), self._code.encode()):
            self._wrong += 1
            rest = self._wrong % GUESSES == 0
            self._closed_until_s = now_s + (REST_S if rest else BETWEEN_S)
            return None
        self._wrong = 0
        token = secrets.token_urlsafe(24)
        self._tokens = [*self._tokens[-MOST_TOKENS + 1 :], token]
        return token


class Names:
    """The names under which this server may be asked for; anything else is a foreign page's trick (DNS rebinding)."""

    def __init__(self, listen: str, port: int) -> None:
        self._port, self._open = port, not is_loopback(listen)
        here = socket.gethostname().lower()
        self._names = {"localhost"} | ({here, f"{here}.local", listen.lower()} if self._open else set())

    def host_ok(self, host: str | None) -> bool:
        """True for a Host header with one of this server's names, or an address, and its port."""
        try:
            parts = urlsplit(f"//{host or ''}")
            name, port = (parts.hostname or "").lower(), parts.port or 80
        except ValueError:
            return False
        return port == self._port and (name in self._names or self._is_address(name))

    def origin_ok(self, origin: str | None, host: str | None) -> bool:
        """True if the page that asks came from this very server."""
        return self.host_ok(host) and origin is not None and origin.lower() == f"http://{host}".lower()

    def _is_address(self, name: str) -> bool:
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return self._open or address.is_loopback
