"""What is wrong with the joints as a whole: each is noticed, named, and answered by the whole robot."""

from concurrent.futures import wait
from contextlib import contextmanager

import pytest

from host.bus.can.joints import CanJoints
from host.commands._hardware import hardware
from host.control.loop import Loop
from host.control.supervisor import Supervisor
from host.protocol.frames import decode, encode
from host.robot.joint_setups import joint_setups
from host.robot.poses import seated_pose_rad
from host.sim.joints.sim_joint import SimJoint
from host.sim.joints.sim_robot import SimRobot, power_off, sim_port
from host.util.errors import UserError
from shared.record import pack, unpack
from shared.wire import names as w
from shared.wire.codec import Heartbeat
from tests.host.control.rig import AHEAD, SCRIPT, STAND, STILL, Silence

from .robot import SESSION, variant


class Rig:
    """The robot over CAN as teleoperation drives it, in simulated time."""

    def __init__(self, threaded=False):
        self.robot = variant()
        self.sim = SimRobot(self.robot)
        self.bus = CanJoints(self.robot, sim_port(self.sim), SESSION, seated_pose_rad(self.robot), threaded=threaded)
        attitude = (lambda: None) if threaded else self.attitude  # only the thread may touch the body
        self.supervisor = Supervisor(self.robot, self.bus, attitude)
        self.loop = Loop(self.supervisor, clock=self.bus.now)

    def attitude(self):
        return 0.0, self.sim.body.pitch(self.sim.time_s)[0]

    def run(self, seconds, message=None):
        for tick in range(round(seconds / self.loop.pacer.period_s)):
            if message is not None and tick % 5 == 0:
                self.loop.receive(SCRIPT, message)
            self.loop.tick(Silence())
            self.bus.run_for(self.loop.pacer.period_s)

    def run_until(self, done, message=None, most_s=15.0):
        end_s = self.bus.now() + most_s
        while not done() and self.bus.now() < end_s:
            self.run(0.1, message)
        assert done()

    def stand(self):
        self.run(0.1)
        self.loop.receive(SCRIPT, STAND)
        self.run_until(lambda: self.supervisor.state == "standing", STILL)


@contextmanager
def opened(threaded=False):
    """Yield the robot with its bus open; whatever happens, its threads and joints end."""
    rig = Rig(threaded)
    try:
        rig.bus.open()
        yield rig
    finally:
        rig.bus.close()
        rig.sim.close()


@pytest.fixture
def rig():
    with opened() as rig:
        yield rig


def forge_heartbeats(sim, node, field, value):
    """Change one field of every heartbeat that a joint sends."""
    joint, send = sim.joints[node - 1], sim.nodes[node - 1].send

    def forged(identifier, data):
        if identifier == w.HEARTBEAT_ID + node:
            values = unpack(Heartbeat(), decode(identifier, data)[0])
            setattr(values, field, value)
            data, _ = encode(identifier, pack(values))
        return send(identifier, data)

    joint.send = forged


def add_twin(sim, node):
    """Attach a second board under a node that is taken."""
    setup = joint_setups(sim.robot)[node - 1]
    twin = SimJoint(sim.robot.actuator, setup, node, sim.body.angle_rad[node - 1], board_number=99)
    end = sim.bus.attach(lambda time_us, identifier, data: twin.deliver(identifier, data))
    twin.send, twin.room = end.send, end.room
    sim.each_ms.append(lambda ms: twin.tick(ms * 1000, sim.body.angle_rad[node - 1]))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda sim: power_off(sim, [9]), r"RR calf \(node 9\) is not there: check its power"),
        (lambda sim: forge_heartbeats(sim, 4, "protocol_hash", 0x1234),
         r"FL hip \(node 4\) speaks protocol 0x1234, this host .*: run caramelo flash --can"),
        (lambda sim: forge_heartbeats(sim, 7, "build", 9),
         r"different firmware: .*build 000009 on nodes 7; caramelo flash --can --all gives all the same"),
        (lambda sim: add_twin(sim, 5), r"FL thigh \(node 5\)"),
    ],
    ids=["missing", "protocol", "build", "twin"],
)  # fmt: skip
def test_what_keeps_the_robot_from_being_armed(seated, spoil, words):
    spoil(seated.sim)
    with pytest.raises(UserError, match=words):
        seated.bus.open()
    assert seated.sim.torque_free


@pytest.mark.parametrize(
    ("spoil", "seconds", "what", "node"),
    [
        (lambda sim: add_twin(sim, 5), 0.5, "duplicate", 5),
        (lambda sim: sim.joints[7].power_cycle(), 0.3, "reset", 8),
        (lambda sim: power_off(sim, [9]), 0.3, "silent", 9),
    ],
    ids=["twin", "reset", "silent"],
)
def test_what_makes_all_joints_damp_that_hold_the_robot(seated, spoil, seconds, what, node):
    """The joint is named, all joints brake and then let go, and stay so."""
    seated.arm()
    seated.go(0.3, mode="stand")
    assert not seated.sim.torque_free
    spoil(seated.sim)
    seated.go(seconds, mode="stand")
    assert what in {notice.what for notice in seated.notices}
    assert {notice.node for notice in seated.notices} == {node}
    assert all(f"(node {node})" in notice.sentence for notice in seated.notices)
    assert seated.bus.cycle.reaction == "damp"
    assert not seated.bus.cycle.armed
    seated.bus.run_for(1.0)
    assert seated.sim.torque_free


def heat(sim):
    sim.joints[2].set_winding(90.0)


def lose_frames(sim):
    sim.nodes[10].loss = 0.25


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (heat, "FR calf (node 3) is hot"),
        (lose_frames, "RL thigh (node 11): more than a tenth of its replies is lost"),
    ],
)
def test_what_makes_the_robot_sit_down_and_then_let_go(rig, spoil, words):
    rig.stand()
    spoil(rig.sim)
    rig.run_until(lambda: rig.supervisor.safety.action == "sit", AHEAD)
    assert words in rig.supervisor.safety.sentence
    rig.run_until(lambda: rig.sim.torque_free, AHEAD)
    assert rig.sim.body.height_m < 0.17  # sitting is 0.13 m, standing 0.25 m
    assert "sitting" in [change.state for change in rig.supervisor.changes] or rig.supervisor.safety.action == "sit"
    assert rig.bus.cycle.reaction == "sit"  # never damped: it went down on its own legs


def test_a_silent_joint_makes_all_damp_and_the_driver_is_told(rig):
    rig.stand()
    power_off(rig.sim, [9])
    rig.run(0.3, AHEAD)
    assert rig.supervisor.safety.action == "damp"
    assert "RR calf (node 9) has not replied" in rig.supervisor.safety.sentence
    assert rig.supervisor.state == "fault"
    rig.run(0.7, AHEAD)
    assert rig.sim.torque_free


def test_after_a_stop_on_the_bus_the_driver_resets_and_stands_up_again(rig):
    rig.run(0.1)
    rig.loop.receive(SCRIPT, STAND)
    rig.run(0.4, STILL)  # not yet so far up that it falls over its legs
    assert not rig.sim.torque_free
    rig.sim.nodes[3].send(w.E_STOP_ID, b"")
    rig.run(0.1, AHEAD)
    assert rig.sim.torque_free
    assert "emergency stop came over the bus" in rig.supervisor.safety.sentence
    rig.run(1.0, AHEAD)
    assert rig.sim.torque_free
    rig.loop.receive(SCRIPT, {"type": "reset"})
    rig.run(0.2)
    assert rig.sim.torque_free
    assert rig.supervisor.safety.sentence == ""
    rig.loop.receive(SCRIPT, STAND)
    rig.run(0.5, STILL)
    assert not rig.sim.torque_free


def test_the_cycle_in_a_thread_of_its_own_stands_the_robot_up():
    """The thread moves the simulated time, so that a busy machine makes no difference."""
    with opened(threaded=True) as rig:
        rig.run_until(lambda: rig.supervisor.measured.complete)
        rig.loop.receive(SCRIPT, STAND)
        rig.run_until(lambda: rig.supervisor.armed, STILL)
        assert not rig.sim.torque_free
        rig.bus.emergency_stop()
        end_s = rig.bus.now() + 0.02
        rig.bus.run_until(end_s)
        assert rig.sim.torque_free


def test_torque_that_nobody_waits_for_any_more_is_taken_away():
    with opened(threaded=True) as rig:
        assert not rig.bus.try_torque()
        wait([rig.bus._tried[rig.bus._arm]])
        assert not rig.sim.torque_free
        rig.bus.run_for(0.3)
        rig.bus.read()
        rig.bus.run_for(0.1)
        assert rig.sim.torque_free
        assert rig.bus.read().complete


def test_a_cycle_that_ends_is_told(monkeypatch):
    with opened(threaded=True) as rig, monkeypatch.context() as patch:
        patch.setattr(rig.bus.cycle, "step", lambda: 1 / 0)
        with pytest.raises(UserError, match="the cycle on simulated has ended: division by zero"):
            rig.bus.run_for(60.0)
        with pytest.raises(UserError, match="has ended"):
            rig.bus.read()


def test_teleoperation_opens_the_joints_and_tells_when_nobody_answers():
    with hardware(variant(), "real", "virtual:caramelo-nobody") as parts:
        assert parts.bus.kind == "can"
        with pytest.raises(UserError, match="no joint answers on virtual caramelo-nobody: check"), parts.bus:
            pass
    with pytest.raises(UserError, match="INTERFACE:CHANNEL"), hardware(variant(), "real", "/dev/ttyACM0"):
        pass
