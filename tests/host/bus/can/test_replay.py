"""Frames that armed the joints once, played again after they have let go: they arm nothing."""

from itertools import pairwise

import pytest

from shared.wire import names as w

HOSTS = (w.E_STOP_ID, w.SYNC_ID, *range(w.SETPOINT_POSITION_ID, w.FAULT_ID), *range(w.SERVICE_REQUEST_ID, 0x400))


@pytest.fixture
def armed(seated):
    """A robot that stands on its legs by what ``heard`` holds: every frame of its host, with its time."""
    heard = []
    seated.sim.bus.log = lambda now_us, identifier, data: heard.append((now_us, identifier, data))
    seated.arm()
    seated.go(0.2, mode="stand")
    assert not seated.sim.torque_free
    seated.sim.bus.log = None
    return seated, [frame for frame in heard if frame[1] in HOSTS]


def play(walker, frames):
    """Send frames at their distances in time, and the host nothing; return whether a joint ever had torque."""
    stranger = walker.sim.bus.attach(lambda time_us, identifier, data: None)
    shift_us, torque = walker.sim.bus.now_us - frames[0][0], False
    for time_us, identifier, data in frames:
        walker.sim.advance_us(time_us + shift_us)
        stranger.send(identifier, data)
        torque = torque or not walker.sim.torque_free
    return torque


@pytest.mark.parametrize("power_cycled", [False, True])
def test_old_frames_arm_nothing(armed, power_cycled):
    walker, frames = armed
    assert len([identifier for _, identifier, _ in frames if identifier >= w.SERVICE_REQUEST_ID]) >= 24
    walker.bus.torque(False)
    walker.bus.run_for(0.3)
    if power_cycled:
        for joint in walker.sim.joints:
            joint.power_cycle()
        walker.sim.advance_ms(300)
    assert walker.sim.torque_free
    assert not play(walker, frames)
    walker.bus.run_for(0.5)
    if not power_cycled:
        walker.bus.torque(True)
        walker.bus.run_for(0.05)
        assert not walker.sim.torque_free, "its own host arms it"


def test_the_challenge_is_another_after_each_arming_and_each_end_of_torque(armed):
    walker, _ = armed
    seen = [[joint.inside.joint.service.challenge for joint in walker.sim.joints]]
    for on in (False, True, False, True):
        walker.bus.torque(on)
        walker.bus.run_for(0.3)
        seen.append([joint.inside.joint.service.challenge for joint in walker.sim.joints])
    for before, after in pairwise(seen):
        assert all(a != b for a, b in zip(before, after, strict=True))
    assert all(0 <= challenge < 1 << 14 for challenges in seen for challenge in challenges)
