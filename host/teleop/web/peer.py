"""Who is at the other end of a connection: an address, or, on this machine, a user.

All users of a machine have the same address, so we ask the kernel who owns a connection (sock_diag(7), an exact
look-up).
"""

import ipaddress
import os
import socket
import struct
from typing import Any

SOCK_DIAG_BY_FAMILY, NLM_F_REQUEST = 20, 1
NO_COOKIE, ALL_STATES = 0xFFFFFFFF, 0xFFFFFFFF
HEAD, REQUEST = struct.Struct("=IHHII"), struct.Struct("=BBBBI")
PORTS, REST = struct.Struct(">HH"), struct.Struct("=III")
UID_AT = HEAD.size + 64  # inet_diag_msg: four bytes, 48 of the socket's id, expires, rqueue, wqueue, uid
IPV6_NETWORK = 64  # bits of a subscriber's prefix: all addresses in it count as one


def peer_of(stream: socket.socket) -> str:
    """Return the name for limits and lock-outs: "user 1000" on this machine, else the address."""
    try:
        there, here = stream.getpeername(), stream.getsockname()
        address = ipaddress.ip_address(there[0].partition("%")[0])
        uid = owner(there, here) if address.is_loopback else None
    except (OSError, ValueError):
        return "unknown"  # it is gone already
    if uid is not None:
        return user(uid)
    if isinstance(address, ipaddress.IPv6Address):
        return str(address.ipv4_mapped or ipaddress.ip_network((int(address), IPV6_NETWORK), strict=False))
    return str(address)


def user(uid: int) -> str:
    """Return a user's name among the peers."""
    return f"user {uid}"


def may_open_sockets() -> frozenset[str]:
    """Return the peers that the Unix socket of ``--socket`` would let in: this user, and root."""
    return frozenset({user(os.getuid()), user(0)})


def owner(there: Any, here: Any) -> int | None:
    """Return the user whose socket on this machine is bound to ``there`` and connected to ``here``; None if unknown."""
    family = socket.AF_INET6 if ":" in there[0] else socket.AF_INET

    def packed(address: str) -> bytes:
        return socket.inet_pton(family, address).ljust(16, b"\0")

    which = PORTS.pack(there[1], here[1]) + packed(there[0]) + packed(here[0]) + REST.pack(0, NO_COOKIE, NO_COOKIE)
    request = REQUEST.pack(family, socket.IPPROTO_TCP, 0, 0, ALL_STATES) + which
    head = HEAD.pack(HEAD.size + len(request), SOCK_DIAG_BY_FAMILY, NLM_F_REQUEST, 1, 0)
    try:
        with socket.socket(socket.AF_NETLINK, socket.SOCK_DGRAM, getattr(socket, "NETLINK_SOCK_DIAG", 4)) as kernel:
            kernel.settimeout(0.1)
            kernel.send(head + request)
            answer = kernel.recv(4096)
    except OSError:
        return None
    if len(answer) < UID_AT + 4 or HEAD.unpack_from(answer)[1] != SOCK_DIAG_BY_FAMILY:
        return None
    uid: int = struct.unpack_from("=I", answer, UID_AT)[0]
    return uid
