"""Twelve emulated servos as a bus: what is measured, what is obeyed, and what stops the robot, in both protocols."""

from math import degrees, isfinite, nan
from operator import methodcaller

import pytest

from host.bus.dynamixel import table as t
from host.bus.dynamixel.budget import budget
from host.bus.dynamixel.calibration.data import Calibration
from host.control.safety import Safety, torque_limit
from host.util.errors import UserError

from .rig import CARAMELO, PERIOD_S, Rig

PROTOCOLS = (1.0, 2.0)


@pytest.fixture(params=PROTOCOLS)
def rig(request):
    """Servos that speak either protocol, behind an open bus."""
    made = Rig(request.param)
    made.bus.open()
    return made


def test_measures_what_the_joints_do(rig):
    measured = rig.read(8)
    assert measured.complete
    assert max(measured.age_s) == 0
    assert isfinite(max(measured.slow_age_s))
    assert measured.battery_V == pytest.approx(12.0)
    assert set(measured.temperature_C) == {30.0}
    for seen, real in zip(measured.position_rad, rig.plant.position_rad, strict=True):
        assert abs(degrees(seen - real)) <= 360 / 4096
    assert rig.bus.counters.errors == 0


def test_speed_and_load_have_the_joints_sign(rig):
    rig.bus.torque(True)
    goals = list(rig.plant.position_rad)
    for joint in range(12):
        goals[joint] += 0.3 if joint % 3 != 2 else 0.2
    rig.bus.write(goals)
    rig.wait(0.06)
    measured = rig.bus.read()
    for joint in range(12):
        assert measured.speed_rad_s[joint] == pytest.approx(rig.plant.speed_rad_s[joint], abs=0.04), joint
        assert measured.speed_rad_s[joint] > 0.5
        assert measured.load[joint] == pytest.approx(rig.plant.drives.load[joint], abs=0.002)
    rig.wait(0.15)  # within the watchdog's time
    measured = rig.bus.read()
    for joint in range(12):
        assert measured.position_rad[joint] == pytest.approx(goals[joint], abs=0.02)


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_set_up_for_quick_answers_and_the_robots_gains(protocol):
    rig = Rig(protocol)
    for servo in rig.servos:
        servo.put(t.P_GAIN, 100)
        servo.put(t.D_GAIN, 7)
    rig.bus.open()
    for servo in rig.servos:
        assert servo.get(t.RETURN_DELAY) == 0
        assert servo.get(t.P_GAIN) == CARAMELO.actuator.p_gain
        assert servo.get(t.D_GAIN) == CARAMELO.actuator.d_gain
        assert not servo.get(t.TORQUE_ENABLE)


def test_switching_on_moves_nothing(rig):
    before = list(rig.plant.position_rad)
    rig.bus.torque(True)
    rig.wait(0.1)
    assert all(servo.follows for servo in rig.servos)
    for was, now in zip(before, rig.plant.position_rad, strict=True):
        assert abs(was - now) < 0.003


def test_goals_are_limited_to_the_calibrated_range_and_to_numbers(rig):
    rig.bus.torque(True)
    rig.bus.write([3.0] * 12)
    for servo, mount in zip(rig.servos, rig.truth.joints, strict=True):
        assert servo.get(t.GOAL_POSITION) == (mount.max if mount.sign > 0 else mount.min)
    for wrong in ([nan] * 12, [0.0] * 11):
        with pytest.raises(ValueError, match="goal"):
            rig.bus.write(wrong)


def test_torque_is_limited_while_standing_up():
    """The register is the robot file's share of full duty, and full again once it stands."""
    rig = Rig(ground=True)
    rig.bus.open()
    rig.read(8)
    rig.tick(mode="limp")  # what the joints are is known from the second reading on
    rig.bus.torque(True)
    limits, loads = set(), []
    for _ in range(20):
        rig.tick(mode="stand")
        assert rig.driver.state == "rising"
        limits |= {servo.get(t.GOAL_PWM) for servo in rig.servos}
        loads.append(max(map(abs, rig.plant.drives.load)))
    share = CARAMELO.stand.torque_fraction
    assert limits == {round(share * t.FULL_PWM)}
    assert max(loads) <= share + 0.001
    while rig.driver.state != "standing":
        rig.tick()
    rig.tick()
    assert {servo.get(t.GOAL_PWM) for servo in rig.servos} == {t.FULL_PWM}
    assert torque_limit(CARAMELO, "walking") == 1.0


def test_a_lower_torque_limit_is_felt():
    weak = Rig(ground=True)
    weak.bus.open()
    weak.read(8)
    weak.bus.torque(True)
    weak.bus.limit_torque(0.05)
    for _ in range(150):
        weak.read()
        weak.driver.set_command(mode="stand")
        weak.driver.sense(weak.measured.position_rad, 0.0, 0.0)
        weak.bus.write(weak.driver.step())
    assert max(map(abs, weak.plant.drives.load)) <= 0.0501
    assert weak.plant.position_rad[2] < -2.0  # still folded: the planner stands, the robot does not


def test_a_limit_that_was_not_heard_is_sent_again(rig):
    rig.bus.torque(True)
    rig.servos[4].put(t.GOAL_PWM, 300)
    rig.read(8)
    assert rig.servos[4].get(t.GOAL_PWM) == t.FULL_PWM


def test_emergency_stop_lets_go_and_keeps_goals_from_being_sent():
    rig = Rig()
    rig.stand_up()
    rig.bus.emergency_stop()
    assert not any(servo.get(t.TORQUE_ENABLE) for servo in rig.servos)
    rig.servos[3].put(t.TORQUE_ENABLE, 1)  # one that did not hear it
    goal = rig.servos[3].get(t.GOAL_POSITION)
    rig.bus.write([0.1] * 12)
    assert rig.servos[3].get(t.GOAL_POSITION) == goal
    rig.read()
    assert not rig.servos[3].get(t.TORQUE_ENABLE)
    rig.bus.emergency_stop()
    rig.bus.torque(True)
    assert all(servo.follows for servo in rig.servos)


def test_closing_lets_go():
    rig = Rig()
    with rig.bus as bus:
        bus.torque(True)
        assert all(servo.follows for servo in rig.servos)
    assert not any(servo.get(t.TORQUE_ENABLE) for servo in rig.servos)
    rig.bus.close()


def test_silence_stops_the_servos_and_is_told():
    rig = Rig()
    rig.stand_up()
    rig.wait(0.19)
    assert all(servo.follows for servo in rig.servos)
    rig.wait(0.2)
    assert not any(servo.follows for servo in rig.servos)
    held = [servo.get(t.GOAL_POSITION) for servo in rig.servos]
    rig.bus.write([0.5] * 12)
    assert [servo.get(t.GOAL_POSITION) for servo in rig.servos] == held
    rig.read(8)
    assert rig.safety.action == "sit"
    assert "heard nothing for 0.2 s" in rig.safety.sentence
    rig.bus.torque(True)
    rig.read(8)
    assert rig.safety.reset(rig.measured) == ""


def missing(servo):
    servo.missing = True


@pytest.mark.parametrize(
    ("ids", "spoil", "words"),
    [
        ([5], missing, "no answer from FL thigh (id 5)"),
        (range(1, 13), missing, "no servo answers at 4000000 baud"),
        ([5], methodcaller("put", t.ID, 77), "77; wrong id? caramelo servos set-id 77 NEW"),
        ([5], methodcaller("put", t.ID, 4),
         "no answer from FL thigh (id 5): check its cable and power, and that no other servo has the same id"),
        ([5], methodcaller("trip"),
         "FL thigh (id 5) has tripped: overload; let it cool, then: caramelo servos reboot 5"),
        ([5], methodcaller("put", t.MODEL_NUMBER, t.MODEL_MX28_V1), "FL thigh (id 5) is model 29, not 30, MX-28(2.0)"),
        ([5], methodcaller("put", t.FIRMWARE, 37), "FL thigh (id 5): firmware below 38 has no bus watchdog"),
    ],
)  # fmt: skip
def test_what_is_wrong_at_the_start_is_named(ids, spoil, words):
    rig = Rig()
    for number in ids:
        spoil(rig.servos[number - 1])
    with pytest.raises(UserError) as wrong:
        rig.bus.open()
    assert words in str(wrong.value)
    assert not any(servo.get(t.TORQUE_ENABLE) for servo in rig.servos)


def test_a_servo_that_does_not_hold_is_named(rig):
    rig.servos[7].trip()
    with pytest.raises(UserError, match=r"RR thigh \(id 8\) does not hold: overload; nothing moves"):
        rig.bus.torque(True)
    assert not any(servo.get(t.TORQUE_ENABLE) for servo in rig.servos)


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(
    ("ids", "spoil", "words"),
    [
        ([8], methodcaller("trip"), "RR thigh (id 8): overload"),
        ([8], methodcaller("put", t.PRESENT_TEMPERATURE, 78), "RR thigh (id 8) is hot: 78 C, allowed 75"),
        ([8], methodcaller("put", t.PRESENT_TEMPERATURE, 85), "RR thigh (id 8)"),
        ([8], missing, "RR thigh (id 8) does not answer"),
        ([8], methodcaller("put", t.ID, 99), "RR thigh (id 8) does not answer"),
        ([8], methodcaller("reboot"), "RR thigh (id 8): let go by itself: did it lose power?"),
        (range(1, 13), methodcaller("put", t.PRESENT_VOLTAGE, 99), "battery low: 9.9 V, allowed 10.2"),
    ],
)
def test_the_robot_sits_down_and_says_why(protocol, ids, spoil, words):
    rig = Rig(protocol, ground=True)
    rig.stand_up()
    for _ in range(50):
        rig.tick(mode="walk", vx_m_s=0.05)
    assert rig.safety.action == "none"
    for number in ids:
        spoil(rig.servos[number - 1])
    ticks = 0
    while rig.driver.state != "seated" and ticks < 700:
        rig.tick()
        ticks += 1
    assert rig.safety.action == "sit"
    assert words in rig.safety.sentence
    assert rig.driver.state == "seated"
    rig.servos[0].trip()
    rig.read(8)
    assert words in rig.safety.sentence  # the first cause stays


def test_a_dead_bus_lets_go():
    rig = Rig(ground=True)
    rig.stand_up()
    for servo in rig.servos:
        missing(servo)
    for _ in range(12):
        rig.tick()
    assert rig.safety.action == "limp"
    assert rig.safety.sentence == "12 joints do not answer: check the bus cable and the power"


def test_a_dip_of_the_battery_is_no_low_battery(rig):
    rig.read(8)
    for servo in rig.servos:
        servo.put(t.PRESENT_VOLTAGE, 99)
    rig.read(30)
    for servo in rig.servos:
        servo.put(t.PRESENT_VOLTAGE, 120)
    rig.read(100)
    assert rig.safety.action == "none"


def test_fallen_is_limp_and_a_reset_needs_the_cause_to_be_gone(rig):
    measured = rig.read(8)
    safety = Safety(CARAMELO)
    assert safety.update(measured, (0.0, 1.2)) == "limp"
    assert safety.reset(measured, (0.0, 1.2)).startswith("the robot has fallen over")
    assert safety.reset(measured, (0.0, 0.1)) == ""
    assert safety.action == "none"


@pytest.mark.parametrize(
    ("protocol", "seconds", "least_m_s"),
    [(1.0, 10, 0.02), (2.0, 10, 0.02), pytest.param(2.0, 60, 0.025, marks=pytest.mark.slow)],
)
def test_walks_on_with_lost_and_damaged_packets(protocol, seconds, least_m_s):
    """One of a hundred is lost and one damaged; in no cycle is anything bad taken for good."""
    rig = Rig(protocol, ground=True)
    rig.stand_up()
    rig.noise.lost = rig.noise.corrupted = 0.01
    asked, answered = rig.bus.counters.sent, rig.bus.counters.answered
    intact, start_m = rig.emulated.intact_answers, rig.plant.world.parts.bodies[0].position.x
    refused = sum(servo.refused for servo in rig.servos)
    oldest_s = 0.0
    for _ in range(round(seconds / PERIOD_S)):
        before = [servo.get(t.GOAL_POSITION) for servo in rig.servos]
        goals = rig.tick(mode="walk", vx_m_s=0.05)
        check_cycle(rig, before, goals)
        oldest_s = max(oldest_s, *rig.measured.age_s)
    counters = rig.bus.counters
    # A damaged length makes the SDK swallow the good answers behind it: those count as lost.
    swallowed = (rig.emulated.intact_answers - intact) - (counters.answered - answered)
    assert 0 <= swallowed < 0.01 * (counters.sent - asked)
    missing = (counters.sent - asked) - (counters.answered - answered)
    assert missing == counters.lost + counters.corrupted
    assert missing > 0.02 * (counters.sent - asked)
    assert counters.corrupted > 0
    assert sum(servo.refused for servo in rig.servos) == refused
    assert rig.safety.action == "none", rig.safety.sentence
    assert rig.driver.state == "walking"
    assert oldest_s <= 0.12
    assert (rig.plant.world.parts.bodies[0].position.x - start_m) / seconds > least_m_s


def check_cycle(rig, before, goals):
    """Each servo's goal is the one sent now or the one it had; each fresh reading is what the servo's register says."""
    per_rad = rig.bus._per_rad
    for joint, (servo, mount) in enumerate(zip(rig.servos, rig.truth.joints, strict=True)):
        sent = mount.limited_counts(goals[joint], per_rad[joint])
        assert servo.get(t.GOAL_POSITION) in (sent, before[joint])
        if rig.measured.age_s[joint] == 0:
            seen = mount.counts(rig.measured.position_rad[joint], per_rad[joint])
            assert seen == servo.get(t.PRESENT_POSITION)


def test_obeying_damaged_packets_would_be_seen():
    """The check of the walk above can fail: a servo that skips the checksum is caught."""
    rig = Rig(ground=True)
    rig.stand_up()
    framing = rig.emulated._framing
    take = framing.take
    framing.take = lambda buffer: (found := take(buffer)) and found._replace(intact=True)
    rig.noise.corrupted = 0.3
    with pytest.raises((AssertionError, IndexError)):
        walk_checked(rig, 500)


def walk_checked(rig, ticks):
    for _ in range(ticks):
        before = [servo.get(t.GOAL_POSITION) for servo in rig.servos]
        check_cycle(rig, before, rig.tick(mode="walk", vx_m_s=0.05))


def test_the_budget_counts_the_bytes_of_a_cycle(rig):
    rig.bus.torque(True)
    wire = {"bytes": 0}
    write, receive = rig.port.writePort, rig.emulated.receive

    def counted_write(packet):
        wire["bytes"] += len(packet)
        return write(packet)

    def counted_receive(*args):
        answers = receive(*args)
        wire["bytes"] += sum(map(len, answers))
        return answers

    rig.port.writePort, rig.emulated.receive = counted_write, counted_receive
    busiest = 0
    for _ in range(8):
        wire["bytes"] = 0
        rig.read()
        rig.bus.write(rig.plant.position_rad)
        busiest = max(busiest, wire["bytes"])
    assert busiest == budget(4_000_000, 50, rig.bus.link.protocol).bytes


def test_the_budget_knows_what_does_not_fit():
    assert budget(4_000_000, 50).fits
    assert not budget(57_600, 50).fits
    assert not budget(4_000_000, 50, latency_ms=16).fits
    assert "does not fit" in budget(57_600, 50).sentence()


def test_a_wrong_calibration_is_not_hidden():
    """Two joints swapped: the readings are swapped, too, so the test above compares something."""
    rig = Rig()
    joints = list(rig.truth.joints)
    joints[1], joints[2] = joints[2], joints[1]
    wrong = Rig(calibration=Calibration("caramelo", tuple(joints)))
    wrong.bus.open()
    measured = wrong.read(8)
    assert abs(measured.position_rad[1] - wrong.plant.position_rad[1]) > 0.5
