"""A stop on CAN: goes before all that waits, is repeated until every joint says so, and nothing holds it up."""

import threading
from concurrent.futures import Future
from itertools import count

import can
import pytest

from host.bus.can import cycle
from host.bus.can.adapter import AdapterPort
from host.bus.can.joints import OVERTAKEN
from host.bus.can.link import RECEIVE_MOST, RECEIVE_S, JointLink
from host.bus.can.port import Port, Received
from host.sim.joints.sim_robot import power_off
from host.util.errors import UserError
from shared.wire import names as w
from tests.host.control.rig import RESET, SCRIPT, STOP, Silence
from tests.waiting import PATIENCE_S

from .robot import SESSION
from .test_reactions import opened

SLOWEST_ID = 0x7FF


def in_time(work):
    """Do some work in a thread; it must come to its end."""
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    assert not thread.is_alive()


def test_a_stop_finds_room_in_a_full_send_buffer(standing):
    port = standing.ports[0]
    while port.send(SLOWEST_ID, bytes(8)):
        continue
    standing.bus.emergency_stop()
    standing.sim.advance_ms(5)
    assert standing.sim.torque_free


@pytest.mark.parametrize("how", ["stop", "disarm"])
def test_letting_go_is_repeated_until_every_joint_says_so(standing, how):
    deaf = (3, 8)
    for node in deaf:
        standing.sim.nodes[node - 1].loss = 1.0
    if how == "stop":
        standing.bus.emergency_stop()
    else:
        standing.bus.cycle.let_go("disarm")
    standing.bus.run_for(0.03)
    assert {joint.node for joint in standing.sim.joints if joint.bridge} == set(deaf)
    assert standing.bus.cycle.letting_go == how
    assert set(standing.bus.cycle.holding) == set(deaf)
    for node in deaf:
        standing.sim.nodes[node - 1].loss = 0.0
    standing.bus.run_for(0.03)
    assert standing.sim.torque_free
    standing.bus.run_for(0.25)
    assert standing.bus.cycle.letting_go == ""
    sent = standing.sim.bus.sent
    standing.bus.run_for(1.0)
    assert standing.sim.bus.sent - sent < 200 * 14 + 5 * 24, "nothing but SYNC, replies and status"


def test_no_reset_as_long_as_a_joint_has_not_said_that_it_let_go(standing):
    power_off(standing.sim, [9])
    standing.bus.emergency_stop()
    with pytest.raises(UserError, match=r"not confirmed to have let go: RR calf \(node 9\): check"):
        standing.bus.clear_faults()
    assert standing.bus.cycle.letting_go == "stop", "still repeated"


def test_closing_lets_go_of_a_joint_that_does_not_hear_its_requests(standing):
    hears = standing.sim.joints[6].hears
    standing.sim.joints[6].hears = lambda identifier: identifier == w.E_STOP_ID and hears(identifier)
    standing.bus.close()
    assert standing.sim.torque_free


def test_no_message_waits_for_the_bus_and_a_stop_ends_what_others_began():
    """The bus stands still, so whatever waited for it would wait for ever."""
    with opened(threaded=True) as rig:
        rig.run_until(lambda: rig.supervisor.measured.complete)
        done = []

        def drive():
            with rig.sim.lock:
                for _ in range(100):
                    rig.loop.receive(SCRIPT, RESET)
                    rig.loop.tick(Silence())
                rig.loop.receive(SCRIPT, {"type": "posture", "posture": "stand"})
                for _ in range(3):
                    rig.loop.tick(Silence())
                rig.loop.receive(SCRIPT, {"type": "posture", "posture": "rest"})
                rig.loop.tick(Silence())
                rig.loop.receive(SCRIPT, STOP)
                done.append(next(iter(rig.bus.port.node.waiting)))

        in_time(drive)
        assert done == [(w.E_STOP_ID, b"")]
        rig.bus.run_for(0.5)
        assert rig.sim.torque_free
        assert rig.bus.cycle.letting_go == ""


def test_work_that_a_stop_overtakes_arms_nothing():
    with opened(threaded=True) as rig:
        rig.run_until(lambda: rig.supervisor.measured.complete)
        with rig.sim.lock:
            assert not rig.bus.try_torque()
            arming = rig.bus._tried[rig.bus._arm]
            rig.bus.emergency_stop()
        rig.bus.run_for(0.5)
        with pytest.raises(UserError, match=OVERTAKEN):
            arming.result(PATIENCE_S)
        assert rig.sim.torque_free
        assert not rig.bus.cycle.armed


def test_a_stop_while_the_cycle_looks_where_the_joints_are_does_not_end_it(monkeypatch):
    """It ends the goals, from another thread and so between any two lines."""
    with opened() as rig:
        rig.bus.cycle.hold()
        monkeypatch.setattr(cycle, "_position", lambda reply: rig.bus.emergency_stop() or 0)
        rig.bus.cycle.step()
        assert rig.bus.cycle.letting_go == "stop"
        assert rig.bus.cycle.goals_brad is None


class Stopped(Future):
    """Work that another thread's emergency stop overtakes while somebody looks whether it is done."""

    def __init__(self, bus):
        super().__init__()
        self._bus = bus
        self.set_exception(UserError(OVERTAKEN))

    def done(self):
        self._bus.emergency_stop()
        return super().done()


@pytest.mark.parametrize("ask", ["try_torque", "try_clear_faults"])
def test_a_stop_while_a_loop_looks_whether_its_work_is_done_is_told(monkeypatch, ask):
    with opened() as rig:
        monkeypatch.setattr(rig.bus, "_soon", lambda do: Stopped(rig.bus))
        with pytest.raises(UserError, match=OVERTAKEN):
            getattr(rig.bus, ask)()


class Flood(Port):
    """Frames that come faster than they are read; each takes ``frame_s`` to read."""

    def __init__(self, frame_s):
        super().__init__()
        self._frame_s, self._numbers = frame_s, count()

    def send(self, identifier, data):
        return True

    def receive(self):
        return Received(self.now(), w.REPLY_ID + 1 + next(self._numbers) % 12, bytes(6))

    def now(self):
        return self._frame_s * next(self._numbers)

    def wait_until(self, time_s):
        return


@pytest.mark.parametrize("frame_s", [0.0, RECEIVE_S / 10])
def test_reading_ends_though_frames_keep_coming(frame_s):
    link = JointLink(Flood(frame_s), SESSION)
    in_time(link.receive)
    assert link.floods == 1
    assert 0 < sum(view.replies for view in link.views.values()) <= (20 if frame_s else RECEIVE_MOST)


def test_looking_for_a_frame_of_ours_ends_too(monkeypatch):
    port = AdapterPort("virtual", "caramelo-flood", 1_000_000)
    foreign = can.Message(arbitration_id=0x12345, is_extended_id=True)
    monkeypatch.setattr(port._bus, "recv", lambda timeout: foreign)
    in_time(port.receive)
    port.close()


def test_a_sender_that_hangs_does_not_hold_up_a_stop():
    port = AdapterPort("virtual", "caramelo-hangs", 1_000_000)
    with port._sending:
        assert not port.send_first(w.E_STOP_ID, b"")
    assert port.send_first(w.E_STOP_ID, b"")
    port.close()
