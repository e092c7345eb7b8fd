"""A terminal on a board's prompt: carries input and output until Ctrl-]."""

import os
import select
import sys
import termios
import tty

from ...util.console import say, write_note
from .link import BoardLink

LEAVE = b"\x1d"  # Ctrl-]


def run_shell(port: str) -> None:
    """Connect this terminal to the board; UserError if the port can't be opened, BoardError if the board goes away."""
    link = BoardLink(port)
    link.open()
    keyboard = sys.stdin.fileno()
    before = termios.tcgetattr(keyboard)
    write_note(f"{port}: Ctrl-] leaves")
    try:
        tty.setraw(keyboard)
        link.send(b"\r\x02")  # to the friendly prompt, whichever was used last
        join(link, keyboard, sys.stdout.fileno())
    finally:
        termios.tcsetattr(keyboard, termios.TCSADRAIN, before)
        link.close()
        say("")


def join(link: BoardLink, keyboard: int, out: int) -> None:
    """Carry bytes both ways until Ctrl-] or the end of input."""

    def show(data: bytes) -> bool:
        os.write(out, data)
        return False

    while True:
        link.listen(0.02, show)
        if not select.select([keyboard], [], [], 0)[0]:
            continue
        data = os.read(keyboard, 256)
        typed, leave, _ = data.partition(LEAVE)
        if typed:
            link.send(typed)
        if leave or not data:
            return
