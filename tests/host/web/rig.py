"""A running `caramelo teleop --sim --direct --web` in processes of its own, and a script that watches it."""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import time


def free_port():
    """Return a port that nobody listens at."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Teleop:
    """The command, with a script connected."""

    def __init__(self, folder, *options, sim=("--sim", "--direct"), host="127.0.0.1"):
        self.port, self._path = free_port(), str(folder / "teleop.sock")
        self.url, self.host = f"http://127.0.0.1:{self.port}", f"127.0.0.1:{self.port}"
        command = [sys.executable, "-m", "host.cli", "teleop", *sim, "--web", "--listen", f"{host}:{self.port}"]
        command += ["--socket", self._path, "--json", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.script, self._buffer = self._connect(), b""
        self.status()

    def _connect(self, seconds=15.0):
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s and self.process.poll() is None:
            script = socket.socket(socket.AF_UNIX)
            try:
                script.connect(self._path)
            except OSError:
                script.close()
                time.sleep(0.05)
            else:
                return script
        raise AssertionError("it did not start")

    def say(self, **message):
        """Send a message as the script."""
        self.script.sendall(json.dumps(message).encode() + b"\n")

    def status(self):
        """Return a status younger than the call; older ones that wait are thrown away. Both clocks are one."""
        asked_s = time.monotonic()
        self.script.settimeout(15.0)
        while True:
            while b"\n" not in self._buffer:
                self._buffer += self.script.recv(1 << 16)
            line, _, self._buffer = self._buffer.partition(b"\n")
            value = json.loads(line)
            if value["type"] == "status" and value["time_s"] >= asked_s:
                return value

    def wait(self, found, seconds=6.0):
        """Return the first status for which ``found`` is true."""
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            status = self.status()
            if found(status):
                return status
        raise AssertionError(f"not within {seconds} s: {status['state']}: {status['reason']}")

    def stop(self):
        """End it by SIGTERM and return its figures."""
        self.script.close()
        self.process.send_signal(signal.SIGTERM)
        rest = self.process.stdout.read()
        self.process.stdout.close()
        self.process.wait(30)
        return json.loads(rest)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self.process.poll() is None:
            with contextlib.suppress(Exception):
                self.stop()
        if self.process.poll() is None:
            self.process.kill()
