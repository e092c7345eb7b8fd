"""The whole robot over CAN in simulated time: walking, lost frames, a dead host, a babbling node, a stop."""

import pytest

from host.util.errors import UserError
from shared.joint.faults import FAULT_EMERGENCY_STOP, FAULT_WATCHDOG
from shared.joint.layout import TORQUE_DAMP, TORQUE_OFF
from shared.wire import names as w

from .robot import Walker


def states(walker, name):
    return [getattr(joint.inside.joint.control.state, name) for joint in walker.sim.joints]


@pytest.mark.parametrize("seconds", [6.0, pytest.param(60.0, marks=pytest.mark.slow)])
def test_walks_with_one_percent_of_frames_lost_and_five_ms_of_jitter(seconds):
    with Walker(jitter_s=0.005, loss=0.01) as walker:
        walker.arm()
        walker.stand_up()
        start_m = walker.sim.body.x_m
        walker.go(seconds)
        assert walker.bus.cycle.armed
        assert walker.notices == []
        assert walker.lowest_m > 0.2
        assert walker.sim.body.x_m - start_m > 0.7 * 0.05 * (seconds - 2)
        counters = walker.bus.counters
        share = counters.lost / counters.sent
        assert 0.005 < share < 0.03  # SYNC, or the reply, or both are missing: near 2 %
        assert all(counters.per_joint_lost)
        assert sum(walker.bus.cycle.timing.late[5:]) > 0


def test_a_host_that_dies_mid_stride_leaves_joints_that_damp_then_coast_and_stay_so(standing):
    standing.go(2.0)
    sim = standing.sim
    sim.advance_ms(120)  # nobody sends any more
    assert states(standing, "torque") == [TORQUE_DAMP] * 12
    sim.advance_ms(600)
    assert states(standing, "torque") == [TORQUE_OFF] * 12
    assert states(standing, "fault_code") == [FAULT_WATCHDOG] * 12
    standing.bus.cycle.run_until(standing.bus.now() + 0.3)  # it is back, and its set-points are not obeyed
    assert sim.torque_free
    assert states(standing, "drive_state") == [w.STATE_FAULT] * 12


def stop_by(walker, sender):
    """Have a node send an e-stop mid-stride; return after how many ms the robot is torque-free."""
    walker.go(1.0)
    assert not walker.sim.torque_free
    sender(w.E_STOP_ID, b"")
    for ms in range(1, 100):
        walker.bus.run_for(0.001)
        if walker.sim.torque_free:
            return ms
    return None


@pytest.mark.parametrize("node", [0, 5, 12, 13])
def test_an_emergency_stop_from_any_node_takes_the_torque_within_20_ms(standing, node):
    """Node 0 is the host, 1 .. 12 are joints, 13 is a button on the bus."""
    sim = standing.sim
    senders = [standing.port.send, *(n.send for n in sim.nodes), sim.bus.attach(lambda *frame: None).send]
    ms = stop_by(standing, senders[node])
    assert ms is not None
    assert ms <= 20  # also of a joint that sends it, and does not hear its own frame: the host answers with another
    for _ in range(50):
        standing.bus.cycle.link.send_setpoints(w.SETPOINT_POSITION_ID, [0] * 12)
        standing.bus.run_for(0.005)
    assert sim.torque_free
    assert set(states(standing, "fault_code")) == {FAULT_EMERGENCY_STOP}
    with pytest.raises(UserError, match="emergency"):
        standing.bus.torque(True)


@pytest.mark.parametrize("identifier", [0x7F0, 0x07F])
def test_a_babbling_node_ends_in_torque_off_or_does_not_matter(standing, identifier):
    """With the lowest priority it only fills gaps; with a priority above SYNC nobody else can speak: watchdog."""
    node = standing.sim.bus.attach(lambda *frame: None)
    standing.sim.each_ms.append(lambda ms: [node.send(identifier, bytes(8)) for _ in range(12)])
    standing.go(1.0)
    if identifier == 0x7F0:
        assert standing.bus.cycle.armed
        assert standing.bus.cycle.reaction == "none"
        return
    standing.bus.run_for(1.0)
    assert standing.sim.torque_free
    assert standing.bus.cycle.reaction == "damp"
    assert standing.port.counters.full > 0  # its own frames found no room: counted, not fatal
