"""The page's address with the pairing code, for a phone's camera: a QR code of half blocks, black on white."""

import io
import socket
from typing import TextIO

WHITE, PLAIN = "\x1b[97;40m", "\x1b[0m"  # of the light modules, which are drawn; independent of the terminal's colours
QUIET = 2  # modules around it


def qr_lines(text: str) -> list[str]:
    """Return the lines of a QR code (ISO/IEC 18004), each with its colours."""
    import segno

    drawn = io.StringIO()
    segno.make_qr(text, error="l").terminal(drawn, border=QUIET, compact=True)
    return [WHITE + line + PLAIN for line in drawn.getvalue().splitlines()]


def shows_blocks(stream: TextIO) -> bool:
    """Return whether a stream goes to a terminal, in an encoding that has the blocks."""
    return stream.isatty() and (stream.encoding or "").lower().replace("-", "") == "utf8"


def own_address() -> str:
    """Return this machine's address in its network, or its name if it has none. This sends nothing."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address for documentation (RFC 5737): only the route is looked up
            return str(probe.getsockname()[0])
        except OSError:
            return f"{socket.gethostname()}.local"


def page_address(address: str, port: int, code: str) -> str:
    """Return the address for the phone: the page of a listener, with the code in the part that no server receives."""
    host = own_address() if address in ("0.0.0.0", "::") else address
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/#{code}"
