"""Position loops on the host walk the robot, and are compared with the joint's own; two buses carry 400 Hz."""

import numpy as np
import pytest

from host.bus.can.load import busload, default_schedule
from host.bus.can.pair import buses_for
from host.lab.joints import compare as comparing
from host.lab.joints.compare import CASES, compare, least_lag
from host.robot.file import find, load_robot
from host.util.errors import UserError
from shared.wire import names as w

from .robot import Walker


def case(loops, rate_hz):
    return next(one for one in CASES if one[:2] == (loops, rate_hz))


def test_loops_on_the_host_walk_the_robot_nearly_as_well_as_the_joints_own():
    robot = load_robot("parallel")
    found = {loops: compare(robot, *case(loops, 200), 2.0) for loops in ("impedance", "joint", "host-velocity")}
    for loops, one in found.items():  # the first cycle, 2 s, is walked at half speed
        assert one.stopped == ""
        assert 0.015 < one.speed_m_s < 0.06, loops
        assert one.error_rms_deg < 2.0


def test_current_mode_holds_the_robot_at_400_hz_on_two_buses():
    """It steps, and hardly gets on."""
    found = compare(load_robot("parallel"), *case("host-current", 400), 2.0)
    assert found.stopped == ""
    assert found.lowest_body_m > 0.2


def test_current_mode_at_200_hz_is_refused_by_the_robot_file(tmp_path):
    text = find("parallel").read_text().replace('loops = "impedance"', 'loops = "host-current"')
    path = tmp_path / "slow.toml"
    path.write_text(text)
    with pytest.raises(UserError, match=r"bus\.rate_hz: value 200: allowed: at least 400 with host-current"):
        load_robot(str(path))


def test_the_lag_between_two_curves_is_found():
    times = np.arange(2000)[:, None]
    goals = np.sin(times / 80.0 + np.arange(12))
    lag, left = least_lag(goals[14:], goals[:-14])
    assert lag == 14
    assert left < 1e-9


def test_the_command_prints_a_walk_of_each_case(run_json, monkeypatch):
    cases = [case("host-velocity", 200)]
    monkeypatch.setattr(comparing, "CASES", cases)
    code, found, _ = run_json("joints", "compare", "--seconds", "1")
    assert code == 0
    assert [(walk["loops"], walk["rate_hz"], walk["buses"]) for walk in found["walks"]] == cases


class Stopped(comparing.SimWalk):
    """A walk that an emergency stop ends after half a second."""

    def stand_up(self):
        super().stand_up()
        switch = self.sim.bus_of(2).attach(lambda *frame: None)
        self.sim.at(500, lambda: switch.send(w.E_STOP_ID, b""))


def test_a_walk_that_the_joints_stop_ends_there(run, monkeypatch):
    """Its speed was told over the whole time, its errors over the walk."""
    monkeypatch.setattr(comparing, "CASES", [case("host-velocity", 200)])
    monkeypatch.setattr(comparing, "SimWalk", Stopped)
    code, out, _ = run("joints", "compare", "--seconds", "1")
    assert code == 1
    assert "host-velocity, 200 Hz: stopped after 0.5 s: an emergency stop came over the bus" in out
    assert out.splitlines()[1].split()[3] == "0.5"


@pytest.mark.parametrize(
    ("more", "most", "off"), [({}, 0.40, 0.01), ({"channel": "can0,can1", "rate_hz": 400}, 0.45, 0.015)]
)
def test_each_bus_is_loaded_as_busload_says(more, most, off):
    """Bits within 1 % of those really sent on it, frames within ``off``; no more than with the worst payloads."""
    with Walker(**more) as walker:
        walker.arm()
        walker.stand_up()
        before = [(bus.sent, bus.bits, bus.now_us) for bus in walker.sim.buses]
        walker.go(1.0)
        assert walker.bus.cycle.armed
        for (sent, bits, start_us), bus in zip(before, walker.sim.buses, strict=True):
            nodes = [node for node in range(1, 13) if walker.sim.bus_of(node) is bus]
            total = busload(default_schedule(walker.robot.bus.rate_hz, nodes))[-1]
            took_us = bus.now_us - start_us
            assert (bus.bits - bits) / took_us == pytest.approx(total.typical_share, rel=0.01)
            assert (bus.bits - bits) / took_us < total.worst_share <= most
            assert (bus.sent - sent) / took_us == pytest.approx(1e-6 * total.frames_per_s, rel=off)


def test_frames_go_to_the_bus_of_their_joints():
    assert buses_for(w.E_STOP_ID) == buses_for(w.SYNC_ID) == buses_for(w.SERVICE_REQUEST_ID) == (0, 1)
    assert [buses_for(w.SETPOINT_POSITION_ID + 8 * group) for group in range(3)] == [(0,), (0, 1), (1,)]
    assert [buses_for(w.UPDATE_BLOCK_ID + part) for part in range(8)] == [(0, 1)] * 8
    assert [buses_for(w.SERVICE_REQUEST_ID + node) for node in (1, 6, 7, 12)] == [(0,), (0,), (1,), (1,)]


@pytest.mark.parametrize("node", [2, 11])
def test_an_emergency_stop_on_one_bus_reaches_the_other_within_20_ms(node):
    with Walker(channel="can0,can1", rate_hz=400) as walker:
        walker.arm()
        walker.go(0.2, mode="stand")
        assert not walker.sim.torque_free
        walker.sim.bus_of(node).attach(lambda *frame: None).send(w.E_STOP_ID, b"")
        for _ in range(20):
            walker.bus.run_for(0.001)
        assert walker.sim.torque_free
        assert [notice.what for notice in walker.notices] == ["e-stop"]
