"""Keyboard and gamepad as messages; the screen."""

import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.control.messages import check
from host.control.telemetry import Extra, status
from host.robot.file import load_robot
from host.teleop import gamepad as pads
from host.teleop.keyboard import HELP, Keyboard, Keys, keys_of
from host.teleop.terminal import screen_lines
from host.util.errors import UserError
from tests.host.control.rig import STOP, Rig

ROBOT = load_robot("caramelo")
FASTEST = (0.2, 0.05, 0.7)


@pytest.fixture
def keys():
    return Keys(ROBOT, "paper-trot", lambda: FASTEST)


def test_keys_of_a_terminal():
    assert keys_of(b"w \x1b[A\x1bOD\x1b[15~\xc3\xa9X") == ["w", " ", "up", "left", "", *keys_of(b"\xc3\xa9"), "x"]


@given(st.binary(max_size=80))
def test_any_bytes_are_keys_or_nothing(data):
    keys = Keys(ROBOT, "paper-trot", lambda: FASTEST)
    for name in keys_of(data):
        message = keys.message(name)
        assert message is None or check(message)


def test_every_key_of_the_map_does_something(keys):
    named = [*"rtgxwsadqezc190ikjlnmuohyb", "space", "up", "down", "left", "right"]
    for name in named:
        assert keys.message(" " if name == "space" else name) is not None, name
    told = " ".join(keys for keys, _ in HELP)
    assert all(name in told for name in named if len(name) == 1 and name not in "9"), "the map on screen is complete"


def test_drive_keys_and_speed_share(keys):
    assert keys.message("w")["vx_m_s"] == pytest.approx(0.5 * FASTEST[0])
    keys.message("0")
    assert keys.message("d")["wz_rad_s"] == pytest.approx(-FASTEST[2])


def test_full_speed_is_what_the_gait_of_the_moment_can():
    rig = Rig()
    keys = Keys(ROBOT, ROBOT.gait.default, rig.supervisor.fastest, share=1.0)
    told = {}
    for gait in ("trot", "paper-trot"):
        rig.send(check({"type": "gait", "gait": gait}), Keyboard.client)
        rig.run(0.1)
        told[gait] = keys.message("w")["vx_m_s"]
        assert told[gait] == pytest.approx(rig.supervisor.driver.fastest(gait)[0])
    assert told["trot"] > 1.5 * told["paper-trot"]


def test_pose_keys_reach_the_limit_and_stay(keys):
    for _ in range(30):
        pose = keys.message("i")["pose"]
    assert pose[2] == pytest.approx(ROBOT.body_limits.z_m)
    assert keys.message("w")["pose"] == pose
    assert keys.message("h")["pose"] == [0.0] * 6


def test_a_terminal_that_closes_is_gone():
    reading, writing = os.pipe()
    keyboard = Keyboard(ROBOT, lambda: FASTEST, reading)
    os.write(writing, b" ")
    assert keyboard.messages() == [STOP]
    os.close(writing)
    with pytest.raises(OSError, match="gone"):
        keyboard.messages()
    os.close(reading)


class FakePad:
    """What evdev.InputDevice offers, as far as it is used."""

    def __init__(self, keys=(pads.BTN_SOUTH,)):
        self._keys, self.events = list(keys), []

    def fileno(self):
        return 0

    def capabilities(self):
        return {pads.EV_KEY: self._keys}

    def absinfo(self, axis):
        return SimpleNamespace(min=-32768, max=32767)

    def read(self):
        events, self.events = self.events, []
        return events

    def say(self, kind, code, value):
        self.events.append(SimpleNamespace(type=kind, code=code, value=value))


def test_gamepad_drives_only_while_its_dead_man_button_is_held():
    device = FakePad()
    pad = pads.open_gamepad(ROBOT, lambda: FASTEST, "/dev/input/event0", lambda path: device)
    device.say(pads.EV_ABS, pads.ABS_Y, -32768)
    assert pad.messages() == []
    device.say(pads.EV_KEY, pads.BTN_TL, 1)
    (message,) = pad.messages()
    assert check(message)["vx_m_s"] == pytest.approx(FASTEST[0])
    assert pad.repeat() == [message]
    device.say(pads.EV_KEY, pads.BTN_TL, 0)
    assert pad.messages() == pad.repeat() == []


def test_gamepad_buttons_and_dead_zone():
    device = FakePad()
    pad = pads.open_gamepad(ROBOT, lambda: FASTEST, "/dev/input/event0", lambda path: device)
    device.say(pads.EV_KEY, pads.BTN_EAST, 1)
    device.say(pads.EV_KEY, pads.BTN_EAST, 0)
    assert pad.messages() == [STOP]
    device.say(pads.EV_KEY, pads.BTN_TL, 1)
    device.say(pads.EV_ABS, pads.ABS_X, 2000)
    assert pad.messages()[-1]["vy_m_s"] == 0.0


def refuse(path):
    raise PermissionError(13, "denied")


def vanish(path):
    raise FileNotFoundError(2, "No such file or directory")


@pytest.mark.parametrize(
    ("opener", "sentence"),
    [(refuse, "usermod -aG input"), (vanish, "No such file"), (lambda path: FakePad(()), "no gamepad found")],
)
def test_no_gamepad_is_explained(opener, sentence):
    with pytest.raises(UserError, match=sentence):
        pads.open_gamepad(ROBOT, lambda: FASTEST, "/dev/input/event0", opener)


def test_the_screen_shows_state_reason_and_keys():
    rig = Rig()
    rig.run(0.1)
    text = "\n".join(screen_lines(status(rig.loop, Extra())))
    for part in ("disarmed", "stand up first", "nobody", "EMERGENCY STOP", "missed 0", "FR", "RL"):
        assert part in text


def pad_events():
    """Return the events of a drive: (s, type, code, value)."""
    lines = (Path(__file__).with_name("pad_events.csv")).read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    return [(float(at), int(kind), int(code), int(value)) for at, kind, code, value in rows]


def test_a_gamepads_events_drive_the_robot():
    """A file of kernel events through the pad's own code: it stands up, walks, stops with the button, stays limp."""
    rig, device = Rig(), FakePad()
    pad = pads.open_gamepad(ROBOT, rig.supervisor.fastest, "/dev/input/event0", lambda path: device)
    events, seen = pad_events(), []
    for tick in range(round(11.0 / rig.loop.pacer.period_s)):
        now_s = tick * rig.loop.pacer.period_s
        while events and events[0][0] <= now_s:
            device.say(*events.pop(0)[1:])
        for message in pad.messages() if device.events else pad.repeat():
            rig.send(check(message), pad.client)
        rig.run(rig.loop.pacer.period_s)
        if not seen or seen[-1][1] != rig.supervisor.state:
            seen.append((now_s, rig.supervisor.state))
    states = [state for _, state in seen]
    assert states == ["disarmed", "standing up", "standing", "walking", "standing", "walking", "disarmed"]
    assert seen[1][0] < 0.1, "the joints are armed over the ticks after the button, none of which waits for them"
    walking_s, standing_s, again_s, stopped_s = (at for at, _ in seen[-4:])
    assert 3.05 <= walking_s < 3.2
    assert 9.0 <= again_s < 9.1, "the stick is still held"
    assert 6.4 < standing_s < 9.0, "it ends once the dead-man button is let go of"
    assert 9.4 <= stopped_s < 9.45
    assert rig.reason == "emergency stop by gamepad: reset it, then stand up"
