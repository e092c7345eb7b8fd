"""The paired browsers, kept over a restart: a file with hashes of their tokens, which alone let nobody in.

Removing a line or the file revokes pairings: the file is read again as soon as it changes.
"""

import hashlib
import hmac
import json
import os
from datetime import date
from pathlib import Path

from ...util.errors import UserError
from ...util.files import write_text

MOST_TOKENS = 32
NAME = "paired.json"


def paired_path() -> Path:
    """Return the file: in the service's state directory, else beside the calibrations of this user."""
    state = os.environ.get("STATE_DIRECTORY")
    if state:
        return Path(state.partition(":")[0]) / NAME
    base = os.environ.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    return Path(base) / "caramelo" / NAME


class Paired:
    """The tokens' hashes with the day of pairing, oldest first; without a ``path`` only while the program runs."""

    def __init__(self, path: Path | None = None) -> None:
        self._path, self._read_at = path, (0, 0)
        self._since: dict[str, str] = {}  # hash: day
        self.trouble = ""  # why pairings are not kept

    def browsers(self) -> dict[str, str]:
        """Return hash and day of each pairing in the file now."""
        self._refresh()
        return dict(self._since)

    def allows(self, token: str) -> bool:
        """Return whether it is the token of a paired browser."""
        self._refresh()
        told = _hash(token)
        return any(hmac.compare_digest(told, each) for each in self._since)

    def add(self, token: str) -> None:
        """Keep a token; the oldest goes when there are too many."""
        self._refresh()
        kept = list(self._since.items())[-MOST_TOKENS + 1 :]
        self._since = {**dict(kept), _hash(token): date.today().isoformat()}
        self._write()

    def forget(self, token: str) -> None:
        """Revoke one."""
        self._refresh()
        if self._since.pop(_hash(token), None) is not None:
            self._write()

    def forget_all(self) -> None:
        """Revoke all: without the file nobody is paired."""
        self._since = {}
        if self._path is None:
            return
        try:
            self._path.unlink(missing_ok=True)
        except OSError as error:
            self.trouble = f"{self._path}: can't be removed: {error.strerror}"

    def _refresh(self) -> None:
        if self._path is None:
            return
        try:
            now = self._path.stat()
            at = (now.st_mtime_ns, now.st_ino)
        except OSError:
            at = (0, 0)
        if at != self._read_at:
            self._read_at, self._since = at, self._read() if at != (0, 0) else {}

    def _read(self) -> dict[str, str]:
        """Return the file's pairings; none if the file can't be used."""
        assert self._path is not None
        try:
            found = json.loads(self._path.read_text())["browsers"]
            return {str(each["hash"]): str(each["since"]) for each in found}
        except (OSError, ValueError, KeyError, TypeError) as error:
            self.trouble = f"{self._path}: can't be read, so no browser is paired: {type(error).__name__}"
            return {}

    def _write(self) -> None:
        if self._path is None:
            return
        text = json.dumps({"browsers": [{"hash": told, "since": day} for told, day in self._since.items()]}, indent=1)
        try:
            write_text(self._path, text + "\n")
            self._path.chmod(0o600)
            now = self._path.stat()
            self._read_at, self.trouble = (now.st_mtime_ns, now.st_ino), ""
        except (OSError, UserError) as error:
            self.trouble = f"pairings are not kept over a restart: {error}"
            self._path = None


def _hash(token: str) -> str:
    """Return a token's hash; tokens are long and random, so a plain hash is enough."""
    return hashlib.sha256(token.encode(errors="surrogatepass")).hexdigest()
