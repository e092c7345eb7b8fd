"""The guided calibration, replayed from answers against servos that are mounted anyhow."""

from dataclasses import replace

import pytest

from host.bus.base import JOINT_LABELS
from host.bus.dynamixel import table as t
from host.bus.dynamixel.calibration.data import counts_per_rad, load_calibration, nominal, save_calibration
from host.bus.dynamixel.calibration.person import AtTerminal, FromFile, matching, read_answers, write_answers
from host.bus.dynamixel.calibration.picture import leg_points, picture
from host.bus.dynamixel.calibration.procedure import Procedure, difference, reference_rad
from host.robot.file import load_robot
from host.robot.kinematics_si import leg_forward
from host.robot.model import LEG_NAMES
from host.robot.poses import rest_pose_rad
from host.sim.servos.stand import SimulatedBench, hidden_mounting
from host.util.errors import UserError

CARAMELO = load_robot("caramelo")


def bench_of(seed):
    return SimulatedBench(CARAMELO, hidden_mounting(CARAMELO, seed))


def answers_of(bench, **changes):
    """Return the answers of a careful person at this bench, but for ``changes``."""
    answers = {"resume": "yes", "write": "yes"} | {f"check {leg}": "yes" for leg in LEG_NAMES}
    for joint, mount in enumerate(bench.truth.joints):
        answers[f"servo {mount.id} joint"] = JOINT_LABELS[joint]
        # A nudge goes to more counts unless that end of the servo's turn is near, which it never is at rest.
        answers[f"servo {mount.id} direction"] = "+" if mount.sign > 0 else "-"
        answers[f"servo {mount.id} limits"] = "file"
    return answers | changes


def procedure(bench, answers, tmp_path):
    return Procedure(CARAMELO, bench, FromFile(answers, "answers"), tmp_path / "unfinished")


@pytest.mark.parametrize("seed", range(4))
def test_finds_exactly_how_the_servos_are_mounted(tmp_path, seed):
    bench = bench_of(seed)
    plan = nominal(CARAMELO)
    assert bench.truth.ids != plan.ids
    assert {joint.sign for joint in bench.truth.joints} == {-1, 1}
    run = procedure(bench, answers_of(bench), tmp_path)
    found = run.run()
    assert found == bench.truth
    assert run.check_legs(found) == []
    assert not any(servo.get(t.TORQUE_ENABLE) for servo in bench.bus.servos)


def test_the_check_pose_is_the_rest_stance(tmp_path):
    bench = bench_of(1)
    run = procedure(bench, answers_of(bench), tmp_path)
    found = run.run()
    held = []
    hold = bench.hold

    def watched(seconds):
        hold(seconds)
        if seconds > 1:
            held.append(list(bench.plant.position_rad))

    bench.hold = watched
    run.check_legs(found)
    assert len(held) == 4
    for leg, pose in enumerate(held):
        for joint in range(leg * 3, leg * 3 + 3):
            assert pose[joint] == pytest.approx(rest_pose_rad(CARAMELO)[joint], abs=0.02)


def test_torque_stays_low(tmp_path):
    bench = bench_of(1)
    worst = []
    advance = bench.bus.advance

    def watched(now_s):
        advance(now_s)
        worst.append(max(map(abs, bench.plant.drives.load)))

    bench.bus.advance = watched
    procedure(bench, answers_of(bench), tmp_path).run()
    assert 0 < max(worst) <= 0.2


def test_wrong_directions_are_caught_by_the_rest_stance_or_the_check(tmp_path):
    """A wrong sign mirrors the joint about its reference: refused where that leaves the limits, else looked at."""
    bench = bench_of(1)
    answers = answers_of(bench)
    thigh = bench.truth.joints[1]
    key = f"servo {thigh.id} direction"
    answers[key] = "-" if answers[key] == "+" else "+"
    found = procedure(bench, answers, tmp_path).run()
    assert found.joints[1].sign == -thigh.sign
    answers["check FR"] = "no"
    assert procedure(bench, answers, tmp_path).check_legs(found) == ["FR"]


def test_a_joint_named_twice_is_refused(tmp_path):
    bench = bench_of(1)
    answers = answers_of(bench)
    ids = sorted(bench.truth.ids)
    answers[f"servo {ids[1]} joint"] = answers[f"servo {ids[0]} joint"]
    with pytest.raises(UserError, match=rf"servo {ids[1]} joint: .* already has servo {ids[0]}"):
        procedure(bench, answers, tmp_path).run()


def test_goes_on_where_it_stopped(tmp_path):
    bench = bench_of(2)
    answers = answers_of(bench)
    ids = sorted(bench.truth.ids)
    missing = answers.pop(f"servo {ids[7]} direction")
    with pytest.raises(UserError, match=rf"servo {ids[7]} direction: missing: allowed: \+, -"):
        procedure(bench, answers, tmp_path).run()
    later = {key: value for key, value in answers.items() if not any(key.startswith(f"servo {i} ") for i in ids[:7])}
    found = procedure(bench, {**later, f"servo {ids[7]} direction": missing}, tmp_path).run()
    assert found == bench.truth


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('robot = "spot"', "begun for another robot"),  # and what else is wrong with such a file: test_setup.py
        ('robot = "caramelo"\n"FR hip" = { id = 250, sign = 1, zero = 0, min = 0, max = 9 }',
         "begun with servo ids that are not on the bus now"),
    ],
)  # fmt: skip
def test_a_spoilt_unfinished_file_is_refused(tmp_path, content, words):
    (tmp_path / "unfinished").write_text(content)
    bench = bench_of(2)
    with pytest.raises(UserError, match=words):
        procedure(bench, answers_of(bench), tmp_path).run()


def test_limits_by_hand(tmp_path):
    bench = bench_of(1)
    servo = bench.truth.joints[1].id
    place = bench.place

    def stiff(number, joint, angle_rad):
        place(number, joint, max(0.0, min(1.2, angle_rad)) if number == servo else angle_rad)

    bench.place = stiff
    found = procedure(bench, answers_of(bench, **{f"servo {servo} limits": "hand"}), tmp_path).run()
    per_rad = counts_per_rad(CARAMELO)[1]
    wanted = sorted(bench.truth.joints[1].counts(angle, per_rad) for angle in (0.0, 1.2))
    assert [found.joints[1].min, found.joints[1].max] == wanted


def test_limits_that_leave_the_rest_stance_out_are_refused(tmp_path):
    bench = bench_of(1)
    servo = bench.truth.joints[1].id
    place = bench.place
    bench.place = lambda number, joint, angle: place(number, joint, min(0.5, angle) if number == servo else angle)
    with pytest.raises(UserError, match="do not contain the rest stance"):
        procedure(bench, answers_of(bench, **{f"servo {servo} limits": "hand"}), tmp_path).run()


def test_a_missing_or_tripped_or_stuck_servo_is_named(tmp_path):
    bench = bench_of(1)
    bench.bus.servos[3].missing = True
    with pytest.raises(UserError, match="11 servos answer"):
        procedure(bench, answers_of(bench), tmp_path).run()
    bench = bench_of(1)
    first = min(bench.truth.ids)
    bench.bus.servo(first).trip()
    with pytest.raises(UserError, match=f"servo id {first} has tripped: overload"):
        procedure(bench, answers_of(bench), tmp_path).run()
    bench = bench_of(1)
    hinge = bench.plant._hinges[bench.truth.ids.index(first)]
    hinge.model = replace(hinge.model, coulomb_Nm=50.0)
    with pytest.raises(UserError, match=f"servo id {first} does not move"):
        procedure(bench, answers_of(bench), tmp_path).run()


def test_the_command_replays_previews_writes_and_keeps_the_former(run, tmp_path):
    bench = bench_of(5)
    answers, out = tmp_path / "answers.toml", tmp_path / "robot.toml"
    write_answers(answers, answers_of(bench))
    assert read_answers(answers) == answers_of(bench)
    call = ("calibrate", "--sim", "--seed", "5", "--answers", str(answers), "--out", str(out))

    def calibrated(*more):
        code, shown, _ = run(*call, *more)
        assert code == 0
        return shown

    assert '+robot = "caramelo"' in calibrated("--preview")
    assert not out.exists()
    calibrated()
    assert load_calibration(out, CARAMELO) == bench.truth
    save_calibration(out, nominal(CARAMELO))
    assert "-hip = { id = 1," in calibrated()
    assert load_calibration(tmp_path / "robot.toml.backup", CARAMELO) == nominal(CARAMELO)
    assert load_calibration(out, CARAMELO) == bench.truth
    record = tmp_path / "record.toml"
    write_answers(record, {"servo 77 joint": "RL calf"})
    assert "nothing changes" in calibrated("--record", str(record))
    assert read_answers(record)["servo 77 joint"] == "RL calf", "older answers stay in a record"
    assert not out.with_name("robot.toml.unfinished").exists()


def test_a_leg_that_looks_wrong_is_not_achieved(run, tmp_path):
    bench = bench_of(5)
    answers = tmp_path / "answers.toml"
    write_answers(answers, answers_of(bench, **{"check RL": "no"}))
    out = str(tmp_path / "robot.toml")
    code, _, err = run("calibrate", "--sim", "--seed", "5", "--answers", str(answers), "--out", out)
    assert code == 1
    assert "RL did not stand as drawn" in err


@pytest.mark.parametrize("content", ["servo = 5", "not toml", ""])
def test_wrong_answer_files_are_one_line(run, tmp_path, content):
    answers = tmp_path / "answers.toml"
    answers.write_text(content)
    code, _, err = run("calibrate", "--sim", "--answers", str(answers), "--out", str(tmp_path / "robot.toml"))
    assert (code, err.count("\n")) == (2, 1)


def test_at_the_terminal_until_the_answer_is_clear(monkeypatch, capsys):
    lines = iter(["what", "fr", "FR  hip"])
    monkeypatch.setattr("builtins.input", lambda prompt: next(lines))
    person = AtTerminal()
    assert person.ask("servo 1 joint", "Which?", ["FR hip", "FR thigh"]) == "FR hip"
    assert person.answers == {"servo 1 joint": "FR hip"}
    assert capsys.readouterr().out.count("answer one of") == 2

    def ended(prompt):
        raise EOFError

    monkeypatch.setattr("builtins.input", ended)
    with pytest.raises(UserError, match="run the command again to go on"):
        person.ask("x", "?", [])


def test_answers_from_a_file_do_not_replace_hands(monkeypatch):
    """At a real robot somebody has to turn the joint before its position means anything."""
    asked = []
    monkeypatch.setattr("builtins.input", lambda prompt: asked.append(prompt) or "")
    assert FromFile({}, "answers", hands=True).ask("servo 1 reference", "Turn it", []) == ""
    assert asked == ["Turn it [Enter] "]
    FromFile({}, "answers").ask("servo 1 reference", "Turn it", [])
    assert len(asked) == 1


def test_answers_by_their_beginning():
    assert matching("Y", ["yes", "no"]) == "yes"
    assert matching("fr t", ["FR hip", "FR thigh"]) == "FR thigh"
    assert matching("", ["yes", "no"]) is None
    assert matching("+", ["+", "-", "again"]) == "+"


@pytest.mark.parametrize("joint", range(12))
def test_the_picture_shows_where_a_larger_angle_goes(joint):
    """Thigh and calf: to the rear, right on the page; hip: to the left of robot and page."""
    drawing = picture(CARAMELO, joint).split("\n")
    at_rest = next(line.index("O") for line in drawing[1:-1] if "O" in line)
    larger = next(line.index("@") for line in drawing[1:-1] if "@" in line)
    assert (larger < at_rest) == (joint % 3 == 0)
    assert max(map(len, drawing)) < 80


def test_the_picture_follows_the_kinematics():
    pose = (0.3, 0.7, -1.2)
    for leg in range(4):
        x, y, z = leg_forward(CARAMELO.geometry.links_m, CARAMELO.side(leg), pose)
        assert leg_points(CARAMELO, leg, pose, False)[-1] == pytest.approx((-x, z))
        assert leg_points(CARAMELO, leg, pose, True)[-1] == pytest.approx((-y, z))


def test_references_are_within_the_limits():
    for joint in range(12):
        low, high = CARAMELO.joint_limits_rad(joint // 3)[joint % 3]
        assert low <= reference_rad(CARAMELO, joint) <= high


def test_no_difference_is_nothing(tmp_path):
    path = tmp_path / "c.toml"
    assert difference(path, nominal(CARAMELO)) != ""
    save_calibration(path, nominal(CARAMELO))
    assert difference(path, nominal(CARAMELO)) == ""


def test_each_answer_is_on_the_disk_when_the_next_question_comes(tmp_path, monkeypatch):
    """A terminal that dies takes no answer with it; taken up again, the record goes on where it was."""
    record = tmp_path / "answers.toml"
    lines = iter(["FR hip", "+"])

    def answer(prompt):
        line = next(lines, None)
        if line is None:
            raise KeyboardInterrupt
        return line

    monkeypatch.setattr("builtins.input", answer)
    person = AtTerminal(record)
    person.ask("servo 1 joint", "Which?", ["FR hip", "FR thigh"])
    assert read_answers(record) == {"servo 1 joint": "FR hip"}
    person.ask("servo 1 direction", "Which way?", ["+", "-"])
    with pytest.raises(KeyboardInterrupt):
        person.ask("servo 2 joint", "Which?", ["FR hip", "FR thigh"])
    lines = iter(["FR thigh"])
    AtTerminal(record).ask("servo 2 joint", "Which?", ["FR hip", "FR thigh"])
    assert read_answers(record) == {
        "servo 1 joint": "FR hip", "servo 1 direction": "+", "servo 2 joint": "FR thigh"}  # fmt: skip


def test_a_record_never_replaces_a_file_of_another_kind(refused, tmp_path):
    path = tmp_path / "thesis.txt"
    path.write_text("years of work")
    refused("calibrate", "--sim", "--record", str(path))
    assert path.read_text() == "years of work"
