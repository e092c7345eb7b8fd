"""Lets go of the servos if the program that holds them dies or hangs: a process of its own, with only the port.

The servos can't do that: their bus watchdog stops them where they are, and they go on holding (docs/servos.md). The
holder sends beats through a pipe, which say whether it wants torque. If the pipe closes while it wants torque, it has
died; if no beat comes for PATIENCE_S, it hangs. In both cases the guardian sends the packet that takes the torque from
all servos, again and again, because it may collide with half a packet of the dead process. This file imports nothing
of the project, so that it starts quickly and shares no fault with the rest.
"""

import contextlib
import os
import select
import subprocess
import sys
import termios

PATIENCE_S = 0.5  # longer than the servos' own watchdog, so that a hiccup ends in a stop and not on the belly (chosen)
TRIES, TRY_S = 20, 0.02
END_S = 2.0
TORQUE, NO_TORQUE = b"1", b"0"
CHUNK = 4096


class Guardian:
    """The holder's end. ``packet`` takes the torque from all servos on the serial port ``port``, a descriptor."""

    def __init__(self, port: int, packet: bytes) -> None:
        theirs, self._beats = os.pipe()
        os.set_blocking(self._beats, False)
        # In a session of its own, because Ctrl-C and Ctrl-Z in the terminal are for the holder.
        self.process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(port), str(theirs), packet.hex()],
            pass_fds=[port, theirs],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )
        os.close(theirs)
        self.alive = True

    def beat(self, torque: bool) -> None:
        """Report that the holder lives, and whether it wants torque; never waits."""
        try:
            os.write(self._beats, TORQUE if torque else NO_TORQUE)
        except BlockingIOError:
            return  # the pipe is full of beats
        except OSError:
            self.alive = False

    def close(self) -> None:
        """End it; the servos have been let go."""
        self.beat(False)
        os.close(self._beats)
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def watch(port: int, beats: int, packet: bytes) -> None:
    """Let go whenever the holder wants torque but does not beat, until it has closed the pipe."""
    torque = False
    while True:
        if not select.select([beats], [], [], PATIENCE_S if torque else None)[0]:
            _let_go(port, beats, packet)
            torque = False
            continue
        data = os.read(beats, CHUNK)
        if data:
            torque = data[-1:] == TORQUE
            continue
        if torque:
            _let_go(port, -1, packet)
        return


def _let_go(port: int, beats: int, packet: bytes) -> None:
    """Send the packet again and again while the holder (-1: it is dead) is silent."""
    waiting = [] if beats < 0 else [beats]
    for _ in range(TRIES):
        with contextlib.suppress(
            OSError, termios.error
        ):  # a busy adapter has room the next time, one that is gone never
            termios.tcflush(port, termios.TCOFLUSH)
            os.write(port, packet)
        if select.select(waiting, [], [], TRY_S)[0]:
            return


if __name__ == "__main__":
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]))
