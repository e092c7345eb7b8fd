"""Who may use the page: only its own origin, and only clients with the terminal's code or of the robot's user."""

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Callable, Collection
from dataclasses import dataclass
from urllib.parse import urlsplit

from .limits import PerPeer
from .paired import Paired

CODE_DIGITS = 6
# Each peer has one guess a second; after five wrong ones it waits a minute, then two, four ... at most an hour. With
# all 254 addresses of a home network that is about 1 300 guesses an hour: two weeks for half of the 10^6 codes.
GUESSES, BETWEEN_S, REST_S, LONGEST_REST_S = 5, 1.0, 60.0, 3600.0


def new_code() -> str:
    """Return a new pairing code."""
    return f"{secrets.randbelow(10**CODE_DIGITS):0{CODE_DIGITS}d}"


def is_loopback(address: str) -> bool:
    """True if only this machine can reach a listener at the address."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"


@dataclass
class Guesser:
    """A peer's wrong guesses since its last right one, and until when its guesses are ignored."""

    wrong: int = 0
    closed_until_s: float = 0.0


class Pairing:
    """Trades the code for a token. ``friends`` are peers that need neither."""

    def __init__(
        self, code: str, friends: Collection[str], clock: Callable[[], float], paired: Paired | None = None
    ) -> None:
        self._code, self._friends, self._clock = code, friends, clock
        self.paired = Paired() if paired is None else paired
        self._guessers = PerPeer(Guesser)

    def allows(self, token: str | None, peer: str) -> bool:
        """True for a paired browser and for a friend."""
        if peer in self._friends:
            return True
        return token is not None and self.paired.allows(token)

    def pair(self, code: str, peer: str) -> str | None:
        """Return a token for the right code; None for a wrong one, or while this peer's guesses are ignored."""
        now_s, guesser = self._clock(), self._guessers[peer]
        if now_s < guesser.closed_until_s:
            return None
        if not hmac.compare_digest(_bytes(code), _bytes(self._code)):
            guesser.wrong += 1
            guesser.closed_until_s = now_s + _rest_s(guesser.wrong)
            return None
        guesser.wrong = 0
        token = secrets.token_urlsafe(24)
        self.paired.add(token)
        return token


def _rest_s(wrong: int) -> float:
    rounds, rest = divmod(wrong, GUESSES)
    return BETWEEN_S if rest else min(REST_S * 2.0 ** min(rounds - 1, 10), LONGEST_REST_S)


def _bytes(text: str) -> bytes:
    """Return a header's bytes, which may not be text."""
    return text.encode(errors="surrogatepass")


class Names:
    """The host names that this server accepts; any other is a foreign page's trick (DNS rebinding)."""

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
        """True if the requesting page came from this server."""
        return self.host_ok(host) and origin is not None and origin.lower() == f"http://{host}".lower()

    def _is_address(self, name: str) -> bool:
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return self._open or address.is_loopback
