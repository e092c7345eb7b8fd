"""Starts the web process and waits until it listens; the loop's end of their common socket goes to the hub."""

import json
import socket
import subprocess
import sys
from dataclasses import dataclass

from ..child import end_child
from ..errors import UserError

START_S = 15.0
END_S = 3.0
DEFAULT = "127.0.0.1:8080"


@dataclass
class WebProcess:
    """The running process, the loop's end of the socket, and where the page is."""

    process: "subprocess.Popen[bytes]"
    stream: socket.socket
    url: str
    code: str

    def close(self) -> None:
        """Hang up, which ends it."""
        self.stream.close()
        end_child(self.process, END_S)


def listen_address(text: str) -> tuple[str, int]:
    """Return address and port of ADDR, ADDR:PORT or [ADDR]:PORT."""
    address, port = text, DEFAULT.rpartition(":")[2]
    if text.startswith("["):
        address, _, rest = text[1:].partition("]")
        port = rest.lstrip(":") or port
    elif text.count(":") == 1:
        address, _, port = text.partition(":")
    if not address or not port.isdecimal() or not 0 < int(port) < 65536:
        raise UserError(f"--listen {text}: allowed: an address, or address:port such as {DEFAULT}")
    return address, int(port)


def start_web(robot: str, listen: str) -> WebProcess:
    """Start the process; UserError if it can't listen. Beyond this machine a pairing code is made."""
    import aiohttp  # noqa: F401  here, so that a missing extra is told before anything runs

    from ..web.access import is_loopback, new_code

    address, port = listen_address(listen)
    code = "" if is_loopback(address) else new_code()
    ours, theirs = socket.socketpair()
    # A session of its own: Ctrl-C in the terminal is the loop's to handle.
    process = subprocess.Popen(
        [sys.executable, "-m", "host.web", str(theirs.fileno())],
        pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )
    theirs.close()
    setup = {"robot": robot, "listen": address, "port": port, "code": code}
    ours.sendall(json.dumps(setup).encode() + b"\n")
    web = WebProcess(process, ours, "", code)
    web.url = _wait(web, address, port)
    return web


def _wait(web: WebProcess, address: str, port: int) -> str:
    """Return the page's address once it is served."""
    web.stream.settimeout(START_S)
    try:
        line = web.stream.makefile("rb").readline()
    except OSError:
        line = b""
    news = json.loads(line) if line else {"error": "the web page's process did not start"}
    if "error" in news:
        web.close()
        raise UserError(news["error"])
    if address in ("0.0.0.0", "::"):
        return f"http://{socket.gethostname()}.local:{port}, or this machine's address"
    return f"http://[{address}]:{port}" if ":" in address else f"http://{address}:{port}"
