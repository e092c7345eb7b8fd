"""Firmware over the joints' bus: loss, reordering, cuts, the bus lost, other protocols, mixtures, foreign images."""

import random

import pytest

from firmware.flash_map import CONFIRMED, HEADER
from host.boards.flash.over_can import CanFlash
from host.bus.can.guard import Guard
from host.bus.can.link import JointLink
from host.bus.can.update_bus import Ask, UpdateBus
from host.sim.joints.sim_robot import SimPort
from host.util.errors import UserError
from shared.wire import names as w

from .can_joints import Bench, CanJoint, image_of, running

OLD = image_of(1, "old")
NEW = image_of(2)
ALL = list(range(1, 13))
KEY = 77


class Robot:
    """Joints with the old firmware on a simulated bus, switched on and running."""

    def __init__(self, nodes=ALL, loss=0.0, seed=0, old=OLD, slots=None, broken=(), port=SimPort):
        self.joints = [CanJoint(node, old, (slots or {}).get(node, 0), broken) for node in nodes]
        self.bench = Bench(self.joints, seed, loss)
        self.port = port(self.bench)
        self.port.node.loss = loss
        self.bench.settle()

    def joint(self, node):
        return next(joint for joint in self.joints if joint.node == node)

    def flash(self, image=NEW, key=KEY):
        """Do what the command does; return each joint's outcome."""
        work = CanFlash(UpdateBus(self.port, key), image, [joint.node for joint in self.joints])
        work.survey()
        return work.run()

    def touched(self):
        """Return how many words were programmed and sectors erased since the joints came."""
        return sum(joint.done for joint in self.joints)


def all_run(robot, image):
    return running(robot.joints) == {image.about.build} and all(
        joint.update.wished() == (joint.slot, CONFIRMED) for joint in robot.joints
    )


def flash_timed(robot, image, most_s=30.0):
    """Flash, and check the bus's load and the time; return seconds and the bits gone by."""
    began_s, bits = robot.port.now(), robot.bench.bus.bits
    outcomes = robot.flash(image)
    assert [outcome.failure for outcome in outcomes] == [""] * len(robot.joints)
    assert all(outcome.changed and outcome.confirmed for outcome in outcomes)
    assert all_run(robot, image)
    seconds = robot.port.now() - began_s
    assert seconds <= most_s
    assert robot.bench.peak_load() <= 0.7
    assert not [complaint for joint in robot.joints for complaint in joint.chip.complaints]
    return seconds, robot.bench.bus.bits - bits


def test_twelve_joints_get_it_at_once_though_a_frame_in_a_hundred_is_lost():
    robot, image = Robot(loss=0.01, seed=3), image_of(3)
    _, bits = flash_timed(robot, image)
    blocks = len(image.slots[1]) // 6
    assert bits < 12 * blocks * 111 / 2  # one by one its blocks alone would be twice as much
    before = robot.touched()
    assert [outcome.changed for outcome in robot.flash(image)] == [False] * 12  # nothing to do
    assert robot.touched() == before


@pytest.mark.slow
@pytest.mark.parametrize(("longest", "most_s"), [(False, 30.0), (True, 45.0)])
def test_twelve_joints_get_a_whole_image(longest, most_s):
    """At the data sheet's typical times of the flash within thirty seconds; at its longest the host goes slower."""
    robot = Robot(loss=0.01, seed=5)
    for joint in robot.joints:
        joint.chip.flash.longest = longest
    seconds, bits = flash_timed(robot, image_of(388), most_s)
    print(f"{seconds:.1f} s, {bits} bits, at most {robot.bench.peak_load():.3f} of the bus in 100 ms")


class Shuffled(SimPort):
    """Requests come late, in another order, and some of them twice."""

    def __init__(self, bench):
        super().__init__(bench)
        self._kept, self._dice = [], random.Random(2)
        bench.each_ms.append(self._let_go)

    def send(self, identifier, data):
        if identifier & 0x780 != w.UPDATE_REQUEST_ID:
            return super().send(identifier, data)
        self._kept += [(identifier, data)] * self._dice.choice((1, 1, 2))
        return True

    def _let_go(self, ms):
        self._dice.shuffle(self._kept)
        for _ in range(self._dice.randrange(4)):
            if self._kept and self._dice.random() < 0.5:
                super().send(*self._kept.pop())


def test_requests_in_another_order_and_twice():
    robot = Robot([1, 2, 3], loss=0.01, port=Shuffled)
    assert [outcome.failure for outcome in robot.flash()] == [""] * 3
    robot.bench.settle(12.0)  # a late begin is left again after ten seconds
    assert all_run(robot, NEW)


def test_joints_in_either_slot_get_their_own_half():
    robot = Robot([1, 2, 3, 4], loss=0.01, slots={2: 1, 4: 1})
    flash_timed(robot, NEW)
    assert [joint.slot for joint in robot.joints] == [1, 0, 1, 0]


def one_cut(at, loss=0.0):
    """Cut a joint's power in its write number ``at`` while two get an image; return what the two run then."""
    robot = Robot([1, 2], seed=at, loss=loss)
    cut = robot.joint(2)
    cut.done, cut.cut_at = 0, at
    try:
        failures = [outcome.failure for outcome in robot.flash()]
    except UserError as error:
        failures = [str(error)]
    assert cut.cut
    assert any("node 2" in failure for failure in failures)
    robot.bench.settle(11.0)  # whoever waits for the host leaves
    cut.power_up()
    robot.bench.settle()
    builds = [joint.build for joint in robot.joints]
    assert set(builds) <= {OLD.about.build, NEW.about.build}
    assert robot.flash(key=KEY + 1)
    assert all_run(robot, NEW)
    return builds


def writes_of_an_update():
    robot = Robot([1, 2])
    robot.joint(2).done = 0
    robot.flash()
    return robot.joint(2).done


def cuts(count):
    """Return ``count`` writes, spread evenly, with the last twelve among them: header, boot record, confirming."""
    writes = writes_of_an_update()
    spread = {1 + i * (writes - 13) // (count - 13) for i in range(count - 12)}
    return sorted(spread | set(range(writes - 11, writes + 1)))


def test_power_that_goes_in_some_writes_leaves_joints_that_start():
    writes = writes_of_an_update()
    found = [one_cut(at) for at in (1, 2, writes // 2, writes - 2, writes - 1)]
    assert [OLD.about.build] * 2 in found
    assert [NEW.about.build] * 2 in found  # in the confirmation


@pytest.mark.slow
def test_power_that_goes_in_any_of_many_writes_leaves_joints_that_start():
    at = cuts(120)
    assert len(at) == 120
    found = [one_cut(place) for place in at]
    new = sum(builds[1] == NEW.about.build for builds in found)
    print(f"{len(found)} cuts: {len(found) - new} start the old firmware, {new} the new, 0 none")


BLOCKS = 86 + len(NEW.slots[1][HEADER:]) // 6  # of the header and the image
MANY = [pytest.param(at, marks=pytest.mark.slow) for at in range(1, BLOCKS, BLOCKS // 40)]


@pytest.mark.parametrize("blocks", [10, 90, 300, *MANY])
def test_a_bus_that_goes_after_so_many_blocks_leaves_the_old_firmware(blocks):
    robot = Robot([1, 2])
    send, left = robot.port.node.send, [blocks]

    def until_lost(identifier, data):
        if identifier & 0x780 == w.UPDATE_BLOCK_ID:
            left[0] -= 1
        if left[0] < 0:
            for node in robot.bench.nodes:
                node.connected = False
            return True
        return send(identifier, data)

    robot.port.node.send = until_lost
    with pytest.raises(UserError):
        robot.flash()
    robot.bench.settle(15.0)
    assert running(robot.joints) == {OLD.about.build}
    assert all(joint.starts == 2 for joint in robot.joints)  # each has left the update by itself
    robot.port.node.send = send
    for node in robot.bench.nodes:
        node.connected = True
    robot.bench.settle(1.0)
    robot.flash(key=KEY + 1)
    assert all_run(robot, NEW)


def test_a_joint_of_another_protocol_is_told_of_and_updated():
    old = image_of(1, "older", protocol=0x1234)
    robot = Robot([1, 2], old=old)
    outcomes = robot.flash()
    assert [outcome.note for outcome in outcomes] == [
        f"spoke protocol 0x1234, unlike this computer's {w.PROTOCOL_HASH:#06x}"
    ] * 2
    assert all_run(robot, NEW)


def guard_of(robot, nodes=(1, 2)):
    link = JointLink(SimPort(robot.bench), 5, nodes)
    robot.bench.settle(0.5)
    link.receive()
    return Guard(link)


def test_a_joint_of_another_protocol_is_not_armed_and_the_remedy_is_named(monkeypatch):
    monkeypatch.setattr("firmware.joint.PROTOCOL_HASH", 0x1234)
    found = guard_of(Robot([1, 2])).before_arming()
    assert [notice.what for notice in found] == ["hash", "hash"]
    assert "speaks protocol 0x1234" in found[0].sentence
    assert found[0].sentence.endswith("caramelo flash --can")


def test_a_mixture_is_not_armed():
    robot = Robot([1, 2])
    work = CanFlash(UpdateBus(robot.port, KEY), NEW, [2])
    work.survey()
    work.run()
    found = guard_of(robot).before_arming()
    assert [notice.what for notice in found] == ["versions"]
    old, new = OLD.about.build[:6], NEW.about.build[:6]
    assert f"build {old} on nodes 1" in found[0].sentence
    assert f"build {new} on nodes 2" in found[0].sentence
    robot.flash(key=KEY + 1)
    assert guard_of(robot).before_arming() == []


def test_a_joint_that_is_updated_is_not_armed():
    robot = Robot([1, 2])
    UpdateBus(robot.port, KEY).ask({1: Ask(w.UPDATE_BEGIN)})
    assert [notice.what for notice in guard_of(robot).before_arming()] == ["updating"]


@pytest.mark.parametrize("state", [w.STATE_OPERATION_ENABLED, w.STATE_QUICK_STOP_ACTIVE, w.STATE_READY])
def test_a_robot_that_stands_is_not_flashed(state):
    robot = Robot([1, 2, 3])
    before = robot.touched()
    control = robot.joint(3).joint.control
    control.motion = lambda: setattr(control.state, "drive_state", state)
    for nodes in ([1, 2, 3], [1]):  # also when the one that stands is not to be flashed
        with pytest.raises(UserError, match=r"FR calf \(node 3\) is armed: let the robot sit down"):
            CanFlash(UpdateBus(robot.port, KEY), NEW, nodes).survey()
    answer = UpdateBus(robot.port, KEY).ask({3: Ask(w.UPDATE_BEGIN)})[3]  # and the joint by itself
    assert (answer.state, answer.reason) == (w.UPDATE_IS_RUNNING, w.UPDATE_WHY_ARMED)
    assert robot.touched() == before


@pytest.mark.parametrize(
    ("told", "sent", "why"),
    [
        (NEW, image_of(1, board="CARAMELO_GAIT"), w.UPDATE_WHY_OTHER_BOARD),
        (NEW, image_of(1, "another"), w.UPDATE_WHY_OTHER_IMAGE),
        (image_of(2, protocol=0x1234), NEW, w.UPDATE_WHY_OTHER_IMAGE),
        (NEW, None, w.UPDATE_WHY_NOT_A_HEADER),
        (NEW, NEW, w.UPDATE_WHY_NONE),
    ],
)
def test_a_foreign_image_is_refused_by_the_joint_before_anything_is_written(told, sent, why):
    robot = Robot([1])
    joint, bus = robot.joint(1), UpdateBus(robot.port, KEY)
    before = robot.touched()
    work = CanFlash(bus, told, [1])
    work.survey()
    bound = told.about.protocol | int(told.about.build[:4], 16) << 16
    bus.ask({1: Ask(w.UPDATE_BEGIN, value=bound)})
    head = sent.slots[1][:HEADER] if sent else bytes(HEADER)
    for number in range(86):
        bus.block(1, number, head[6 * number : 6 * number + 6], header=True)
    bus.wait(0.01)  # requests overtake blocks
    if why == w.UPDATE_WHY_NONE:
        assert joint.joint.updating.state == w.UPDATE_IS_CHECKED
        return
    refused = bus.ask({1: Ask(w.UPDATE_ERASE)})[1]
    assert (refused.state, refused.reason) == (w.UPDATE_IS_REFUSED, why)
    assert robot.touched() == before
    robot.bench.settle(12.0)
    assert joint.starts == 2
    assert joint.build == OLD.about.build


def test_a_firmware_that_does_not_start_is_told_and_the_old_one_is_back():
    robot = Robot([1, 2], broken=(NEW.about.build,))
    robot.joint(1).broken = ()
    outcomes = robot.flash()
    assert outcomes[0].failure == ""
    back = f"the new firmware did not start; build {OLD.about.build} runs again"
    assert outcomes[1].failure == f"FR thigh (node 2): {back}"
    assert [joint.build for joint in robot.joints] == [NEW.about.build, OLD.about.build]


def test_a_joint_that_falls_silent_while_it_erases_is_told_and_nothing_is_switched():
    robot = Robot([1, 2])
    silent = robot.joint(2)
    silent.done, silent.cut_at = 0, 1
    with pytest.raises(UserError, match=r"FR thigh \(node 2\) has not answered for 5 s while erasing its flash"):
        robot.flash()
    robot.bench.settle(2.0)
    assert robot.joint(1).build == OLD.about.build
    assert robot.joint(1).joint.updating.state == w.UPDATE_IS_RUNNING


def test_a_slot_that_holds_the_image_already_is_not_written_again():
    robot = Robot([1])
    robot.flash()
    robot.flash(OLD, KEY + 1)
    assert all_run(robot, OLD)
    before = robot.touched()
    assert robot.flash(NEW, KEY + 2)[0].changed
    assert all_run(robot, NEW)
    assert robot.touched() - before == 4  # two boot records of two words


def test_a_trial_that_nobody_confirmed_is_confirmed():
    robot = Robot([1])
    work = CanFlash(UpdateBus(robot.port, KEY), NEW, [1])
    work.survey()
    work._write([1])
    work._switch([1])  # and there the computer goes
    assert robot.joint(1).update.wished() == (1, 2)
    assert [outcome.changed for outcome in robot.flash(key=KEY + 1)] == [False]
    assert all_run(robot, NEW)
