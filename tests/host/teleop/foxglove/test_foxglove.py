"""`caramelo teleop --foxglove` whole: a viewer sees the robot, drives it once paired, as one among others."""

import asyncio
import json
import re
import socket
import subprocess
import sys
import time

import aiohttp
import pytest

from host.lab.teleop.watched import free_port
from host.records.channels import DRAWN
from tests.host.control.rig import AHEAD, SIT, STAND, STILL
from tests.host.teleop.foxglove.viewer import Viewer
from tests.waiting import PATIENCE_S

pytest.importorskip("foxglove", reason="the SDK is not installed (extra foxglove)")

TAKE = {"type": "take"}
TWIST = {"linear": {"x": 0.05, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}


class Drive:
    """The command without the servo bus, and a script at its socket."""

    def __init__(self, folder):
        self.port, path = free_port(), str(folder / "teleop.sock")
        command = [sys.executable, "-m", "host.cli", "teleop", "--sim", "--direct", "--foxglove", "--foxglove-port"]
        command += [str(self.port), "--socket", path, "--json"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.code = re.search(r"pairing code (\d{6})", self.process.stderr.readline())[1]
        self.script = socket.socket(socket.AF_UNIX)
        self.script.connect(path)

    def say(self, message):
        self.script.sendall(json.dumps(message).encode() + b"\n")

    def close(self):
        self.script.close()
        self.process.terminate()
        out, err = self.process.communicate(timeout=60)
        return json.loads(out), err


@pytest.fixture
def drive(tmp_path):
    drive = Drive(tmp_path)
    yield drive
    if drive.process.poll() is None:
        drive.close()


def run(drive, script):
    """Run a coroutine with a viewer that sees the status."""

    async def whole():
        async with aiohttp.ClientSession() as session:
            viewer = await Viewer.connect(session, drive.port)
            await viewer.subscribe("/status")
            await viewer.advertise("/command", "/cmd_vel")
            return await script(viewer, session)

    return asyncio.run(whole())


async def status(viewer):
    return (await viewer.newest("/status"))[1]


async def sees(viewer, found, keep=None):
    """Wait for a status; before each publish ``keep`` (topic and message)."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            if keep is not None:
                await viewer.publish(*keep)
            if found(now := await status(viewer)):
                return now


def drives(now, source):
    return now["driver"] is not None and now["driver"][0] == source


def walks(now):
    """Say whether it walks for a viewer: one that a busy machine halts is not heard for a while."""
    return now["state"] == "walking" and drives(now, "foxglove")


async def script_drives(viewer, drive):
    """Let the script take the controls until a status says so: a driver who is silent for 3 s has left."""
    async with asyncio.timeout(PATIENCE_S):
        while not drives(await status(viewer), "script"):
            drive.say(TAKE)


async def pair(viewer, drive):
    await viewer.publish("/command", {"type": "pair", "code": drive.code})
    await viewer.until(lambda: any("paired" in note for note in viewer.notes))


def test_a_viewer_sees_the_robot_and_drives_it(drive):
    async def script(viewer, session):
        assert viewer.server["name"] == "caramelo: caramelo (simulation)"
        assert "clientPublish" in viewer.server["capabilities"]
        await viewer.subscribe(*DRAWN)
        names = {topic: viewer.channels[topic]["schemaName"] for topic in DRAWN}
        assert names == {topic: rule["title"] for topic, rule in DRAWN.items()}
        _, scene = await viewer.newest("/scene")
        assert len(scene["entities"]) == 13
        _, description = await viewer.newest("/robot_description")
        assert description["data"].startswith("<?xml")
        await pair(viewer, drive)
        await viewer.publish("/command", STAND)
        await sees(viewer, lambda now: now["state"] == "standing", ("/command", STILL))
        before = (await viewer.newest("/odometry"))[1]["pose"]["position"]
        await sees(viewer, lambda now: now["odometry"][0] > 0.05 and walks(now), ("/cmd_vel", TWIST))
        time_ns, pose = await viewer.newest("/odometry")
        assert pose["pose"]["position"]["x"] > before["x"] + 0.02
        assert abs(time_ns - time.time_ns()) < PATIENCE_S * 1e9
        _, moved = await viewer.newest("/tf")
        assert {each["child_frame_id"] for each in moved["transforms"]} > {"base_link", "FR_foot"}
        still = await sees(viewer, lambda now: not now["fresh"])  # the dead-man: nothing is published any more
        assert still["speed"] == [0.0, 0.0, 0.0] or still["state"] == "walking"
        await sees(viewer, lambda now: now["state"] == "standing")
        await viewer.publish("/command", {"type": "stop"})
        assert (await sees(viewer, lambda now: now["stop"]))["stop"].startswith("foxglove")

    run(drive, script)
    figures, _ = drive.close()
    assert figures["bad_messages"] == 0


def test_nobody_drives_without_the_code_and_guesses_are_few(drive):
    async def script(viewer, session):
        await viewer.publish("/command", STAND)
        await viewer.until(lambda: any("is not paired" in note for note in viewer.notes))
        for code in ("wrong", "wrong", drive.code):  # the right one too soon after a wrong one
            await viewer.publish("/command", {"type": "pair", "code": code})
        await viewer.publish("/command", {"type": "stop"})
        await viewer.publish("/cmd_vel", TWIST)
        await viewer.publish("/command", {"type": "fly"})  # is told, and so all before it has been heard
        await viewer.until(lambda: any("/command: " in note for note in viewer.notes))
        assert any("wrong code" in note for note in viewer.notes)
        for _ in range(10):
            now = await status(viewer)
            assert (now["driver"], now["stop"], now["armed"], now["obeyed"]) == (None, None, False, 0)

    run(drive, script)


def test_a_viewer_is_one_driver_among_others(drive):
    async def script(viewer, session):
        await script_drives(viewer, drive)
        await pair(viewer, drive)
        await sees(viewer, lambda now: drives(now, "foxglove"), ("/command", TAKE))
        drive.say(SIT)
        await sees(viewer, lambda now: now["refused"] > 0, ("/command", STILL))
        second = await Viewer.connect(session, drive.port)
        await second.advertise("/command")
        await pair(second, drive)
        await sees(viewer, lambda now: drives(now, "foxglove"), ("/command", TAKE))  # it was silent for a while
        await second.publish("/command", AHEAD)  # of equals the first one keeps it
        await second.until(lambda: any("refused" in note for note in second.notes))
        await viewer.close()
        await second.subscribe("/status")
        await sees(second, lambda now: not drives(now, "foxglove"))
        await sees(second, lambda now: drives(now, "foxglove"), ("/command", TAKE))
        await second.close()

    run(drive, script)
