"""A drive on emulated servos that this test owns, with what hangs on request: disk, page, pipe, terminal."""

import contextlib
import os
import signal
import time

from host.bus.dynamixel.calibration.data import nominal, save_calibration
from host.commands.teleop import END_MOST_S
from host.lab.teleop.bench import LINES
from host.lab.teleop.watched import Watched
from host.robot.file import load_robot
from host.sim.servos.process import Emulator
from host.util.errors import UserError
from tests.host.control.rig import STILL
from tests.processes import child_of
from tests.waiting import wait_until

# Read by every Python that starts with this folder in its path: fsync does not return while the file is there.
SLOW_DISK = """
import os, time
_fsync = os.fsync
def fsync(descriptor):
    while os.path.exists({flag!r}):
        time.sleep(0.05)
    _fsync(descriptor)
os.fsync = fsync
"""
# The same, for the alarm that ends a drive whose end hangs: it comes sooner.
SOON = """
import signal
_alarm = signal.alarm
signal.alarm = lambda seconds: _alarm(min(seconds, {most_s}))
"""
AGAIN_S = 90.0  # what does not walk by then is started again


class Drive(Watched):
    """The command on the servos of ``emulator``, or on none (None); what is left of it is killed at the end."""

    def __init__(self, folder, monkeypatch, emulator, end_most_s):
        self.emulator, self.flag = emulator, folder / "the disk hangs"
        self.page = 0
        changes = SLOW_DISK.format(flag=str(self.flag)) + SOON.format(most_s=end_most_s)
        (folder / "sitecustomize.py").write_text(changes)
        monkeypatch.setenv("PYTHONPATH", str(folder))
        sim = ("--sim", "--direct") if emulator is None else self._port(folder, emulator.port)
        super().__init__(folder, "--log", str(folder / f"{time.monotonic()}.mcap"), sim=sim)
        self.page = child_of(self.process.pid, "host.teleop.server")

    @staticmethod
    def _port(folder, port):
        robot = load_robot("caramelo")
        save_calibration(folder / "nominal.toml", nominal(robot))
        return "--port", port, "--calibration", str(folder / "nominal.toml")

    def __exit__(self, *_):
        self.flag.unlink(missing_ok=True)
        if self.page:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.page, signal.SIGCONT)
        self.process.kill()
        super().__exit__(None, None, None)

    def walk(self):
        """Stand up and walk."""
        self.stand_up(lambda status: status["state"] == "standing")
        self.wait(lambda status: self.drive(0.05) or status["state"] == "walking", AGAIN_S)

    def stand_up(self, enough):
        """Ask to stand up, at rest, until ``enough``."""
        self.stand(lambda what: self.say(**LINES[what]), lambda status: self.drive(0.0) or enough(status), AGAIN_S)

    def drive(self, vx_m_s):
        self.say(**{**STILL, "vx_m_s": vx_m_s})

    def hang(self, what):
        """Have ``disk`` or ``page`` stand still; a page that is just gone comes again later."""
        if what == "disk":
            self.flag.touch()
        elif what == "page":
            with contextlib.suppress(LookupError):
                self.page = child_of(self.process.pid, "host.teleop.server")
                os.kill(self.page, signal.SIGSTOP)

    def holds(self):
        return any(self.emulator.ask("state")["torque"])

    def until_off(self, began_s=None):
        """Return how long from then, or from now, until no servo has torque, s."""
        began_s = time.monotonic() if began_s is None else began_s
        wait_until(lambda: not self.holds(), "the robot is let go", every_s=0.001)
        return time.monotonic() - began_s


@contextlib.contextmanager
def driving(folder, monkeypatch, servos=True, end_most_s=END_MOST_S):
    """Yield a drive that walks, and that the system ends ``end_most_s`` after it let go at the latest.

    The servos of a busy machine answer too late at times: then it is started again.
    """
    for last in (False, False, True):
        with contextlib.ExitStack() as stack:
            try:
                emulator = stack.enter_context(Emulator()) if servos else None
                drive = stack.enter_context(Drive(folder, monkeypatch, emulator, end_most_s))
                drive.walk()
            except UserError:
                if last:
                    raise
                continue
            yield drive
            return
