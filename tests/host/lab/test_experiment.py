"""`caramelo experiment` and `caramelo export`: figures that depend on no timing, whole files, plain errors."""

import importlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from host.lab.experiments import compare, steps, table1
from host.lab.experiments.data import assumptions, papers
from host.lab.experiments.outcome import Outcome
from host.lab.experiments.pool import run_all
from host.lab.experiments.requirements import inspection
from host.lab.experiments.trials import Answer, Options, PlaneTrial, trial_conditions, with_knees
from host.robot.file import load_robot
from host.sim.energy import mean_power_W
from host.sim.walk import WalkSpec
from tests.interrupts import hear_ctrl_c
from tests.waiting import PATIENCE_S, wait_until

np = pytest.importorskip("numpy")
pytest.importorskip("pymunk", reason="pymunk is not installed (extra sim)")
pytest.importorskip("scipy", reason="scipy is not installed (extra sim)")

ROBOT = load_robot("caramelo")
CARAMELO = Path(sys.executable).parent / "caramelo"


def has_mujoco():
    try:
        import mujoco  # noqa: F401
    except ModuleNotFoundError:
        return False
    return True


# --- statistics


def test_the_papers_t_tests_are_reproduced():
    """The paper's printed p of table 1 are two-sided Student; those of table 2 one-sided, of the roll range."""
    table = papers()["table1"]
    for quantity, printed in table["printed_p"].items():
        first, second = (compare.published(table["trials"], case[quantity]) for case in table["case"])
        assert compare.t_test(first, second) == pytest.approx(printed, abs=5e-4)
    cases = papers()["table2"]["case"]
    for at, ground in ((0, "flat"), (2, "stones")):
        first, second = (compare.published(case["n"], case["roll_range_deg"]) for case in cases[at : at + 2])
        assert compare.t_test(first, second) / 2 == pytest.approx(papers()["table2"]["printed_p"][ground], rel=0.02)


def test_a_t_test_of_values_is_scipys():
    from scipy import stats

    a, b = [1.0, 2.0, 4.0, 4.5], [2.5, 3.5, 5.0, 6.0, 7.5]
    assert compare.t_test(compare.sample(a), compare.sample(b)) == pytest.approx(stats.ttest_ind(a, b).pvalue, rel=1e-3)


def test_no_p_value_where_nothing_varies():
    same = compare.sample([1.0, 1.0, 1.0])
    assert compare.t_test(same, compare.sample([2.0, 2.0])) is None
    assert compare.t_test(compare.sample([1.0]), compare.sample([2.0, 3.0])) is None


# --- energy


def test_a_stalled_servo_draws_its_data_sheets_power():
    """One servo stalled at 12 V: 12 V x 1.4 A, plus twelve servos' standby and the computer."""
    torque = np.zeros((5, 12))
    torque[:, 1] = 2.5
    rest = 12 * 0.1 * 12.0 + 5.0
    assert mean_power_W(ROBOT, torque * 0, torque * 0) == pytest.approx(rest)
    assert mean_power_W(ROBOT, torque, torque * 0) == pytest.approx(rest + 12 * 1.4)


def test_a_driven_joint_takes_mechanical_power_and_a_braked_one_gives_none_back():
    torque, speed = np.zeros((4, 12)), np.zeros((4, 12))
    torque[:, 0], speed[:, 0] = 1.0, 2.0
    current = 1.4 / 2.5
    rest = mean_power_W(ROBOT, torque * 0, torque * 0)
    assert mean_power_W(ROBOT, torque, speed) == pytest.approx(rest + current**2 * 12 / 1.4 + 2.0, abs=2e-3)
    assert mean_power_W(ROBOT, torque, -10 * speed) == pytest.approx(rest)


def test_the_rods_ratio_lowers_the_calf_motors_torque_not_its_power():
    torque, speed = np.zeros((2, 12)), np.zeros((2, 12))
    torque[:, 2], speed[:, 2] = 1.0, 1.0
    ratio = ROBOT.calf_drive.ratio
    rest = mean_power_W(ROBOT, torque * 0, torque * 0)
    copper = (ratio * 1.4 / 2.5) ** 2 * 12 / 1.4
    assert mean_power_W(ROBOT, torque, speed) == pytest.approx(rest + copper + 1.0, abs=2e-3)


def test_a_calfs_motor_on_the_body_turns_with_thigh_and_calf():
    """While only the thigh turns, both motors do; while the calf turns back as far, its motor rests."""
    robot = load_robot("parallel")
    torque, speed = np.zeros((2, 12)), np.zeros((2, 12))
    torque[:, 2], speed[:, 1] = 1.0, 3.0
    drive = robot.actuator
    held = mean_power_W(robot, torque, speed * 0)
    assert mean_power_W(robot, torque, speed) == pytest.approx(held + 3.0 / drive.gear.efficiency, abs=2e-3)
    speed[:, 2] = -3.0
    assert mean_power_W(robot, torque, speed) == pytest.approx(held, abs=2e-3)


def test_inspecting_takes_longer_and_more_when_slower():
    def walked(speed_m_s, power_W):
        walk = Answer({"ok": True, "mean_speed_m_s": speed_m_s, "power_W": power_W})
        easy = Answer({"ok": True, "mean_speed_m_s": 0.2, "power_W": 1.0})
        return inspection(ROBOT, {"plane": [easy], "3-D": [walk]})

    fast, slow, hungry = walked(0.05, 20.0), walked(0.01, 20.0), walked(0.05, 200.0)
    lanes, side = 15, 50**0.5
    assert fast["data"]["time_s"] == round(lanes * side / 0.05 + 14 * np.pi / 0.4)
    assert fast["met"]
    assert not slow["met"]
    assert not hungry["met"]
    assert fast["data"]["simulator"] == "3-D"
    assert not inspection(ROBOT, {"plane": [Answer({"ok": False})]})["met"]


# --- trials


def test_trials_differ_by_seed_and_stay_in_their_ranges():
    ranges = assumptions()["trial"]
    for seed in range(20):
        drawn = trial_conditions(ROBOT, seed)
        assert drawn == trial_conditions(ROBOT, seed)
        assert 11.1 <= 12 * (1 - ranges["voltage_drop"]) <= drawn["voltage_V"] <= 12.0
        assert ranges["delay_s"][0] <= drawn["bus_delay_s"] <= ranges["delay_s"][1]
    assert trial_conditions(ROBOT, 0) != trial_conditions(ROBOT, 1)


@pytest.mark.parametrize("knees", ["full-elbow", "full-knee", "elbow-knee", "knee-elbow"])
def test_every_knee_configuration_stands(knees):
    robot = with_knees(ROBOT, knees)
    signs = [robot.knee_sign(leg) for leg in range(4)]
    assert signs == {"full-elbow": [-1] * 4, "full-knee": [1] * 4, "elbow-knee": [-1, -1, 1, 1],
                     "knee-elbow": [1, 1, -1, -1]}[knees]
    assert PlaneTrial(WalkSpec(robot, "paper-trot", distance_m=0.05)).run().ok


def test_offsets_go_across_a_stride_at_both_frictions():
    tried = steps.conditions(Options(ROBOT, "trot"))
    assert len(tried) == 20
    assert len({offset for offset, _ in tried}) == 10
    assert {friction for _, friction in tried} == {0.6, 0.9}
    assert max(offset for offset, _ in tried) < steps.STRIDE_M


def test_a_failed_step_tells_where_it_started_and_why():
    tried = [(0.0, 0.6), (0.05, 0.9)]
    row = steps.verdict(tried, [Answer({"ok": True, "reason": "arrived"}), Answer({"ok": False, "reason": "fell"})])
    assert row == {"passed": 1, "trials": 2, "failures": [{"offset_m": 0.05, "friction": 0.9, "reason": "fell"}]}


def test_answers_are_the_same_for_any_number_of_jobs():
    options = Options(ROBOT, "paper-trot", trials=2, in_space=False)
    tasks = table1.tasks(options)
    heard = []
    one = table1.evaluate(options, run_all(tasks, 1, lambda done: None)).result
    two = table1.evaluate(options, run_all(tasks, 2, heard.append)).result
    assert one == two
    assert heard == [1, 2, 3, 4]


class Broken:
    def run(self):
        raise ArithmeticError("this trial is broken")


def test_an_error_in_a_trial_is_not_swallowed():
    with pytest.raises(ArithmeticError, match="this trial is broken"):
        run_all([Broken(), Broken()], 2, lambda done: None)


def test_the_foot_in_the_air_is_as_measured():
    """Without the hip: highest point and time as the real robot's (paper: 47.6 mm; median time 0.557 s)."""
    case = table1.AirTrial(ROBOT, (0.05, 0.0), {"voltage_V": 12.0, "bus_delay_s": 0.02}, in_space=False).run().figures()
    assert case["z_max_m"] == pytest.approx(0.0476, abs=0.001)
    assert case["time_s"] == pytest.approx(0.557, abs=0.015)
    assert case["x_final_m"] == pytest.approx(0.05, abs=0.001)


CANNED = {
    "mean_speed_m_s": 0.04, "speed_m_s": 0.041, "pitch_range_deg": 3.0, "roll_range_deg": 4.0, "power_W": 30.0,
    "whole_pitch_range_deg": 3.5, "whole_roll_range_deg": 4.5, "yaw_drift_deg": 1.0, "side_drift_m": 0.01,
    "torque_rms_fraction": {"FR_calf": 0.3, "FR_thigh": 0.35}, "reason": "arrived",
}
FELL = Answer({**CANNED, "ok": False, "reason": "fell at 3.00 s"})
ARRIVED = Answer({**CANNED, "ok": True})


def evaluated(name, answer_of, in_space=True):
    """Return an experiment's outcome for made-up answers, one for each of its tasks."""
    module = importlib.import_module(f"host.lab.experiments.{name}")
    options = Options(ROBOT, "paper-trot", trials=2, in_space=in_space)
    tasks = module.tasks(options)
    outcome = module.evaluate(options, [answer_of(task) for task in tasks])
    json.dumps(outcome.result, allow_nan=False)
    for table in outcome.tables:
        assert all(len(row) == len(table.head) for row in table.rows), table.title
        assert all(isinstance(cell, str) for row in table.rows for cell in row), table.title
    return outcome.result


@pytest.mark.parametrize("in_space", [True, False])
@pytest.mark.parametrize("name", ["table2", "ramp", "steps", "payload", "requirements", "goals"])
def test_every_experiment_sums_up_success_and_failure(name, in_space):
    good = json.dumps(evaluated(name, lambda task: ARRIVED, in_space))
    bad = json.dumps(evaluated(name, lambda task: FELL, in_space))
    assert good != bad


def test_steps_json_is_as_promised():
    """One failure in one group: height, kind, gait, counts, and the failure's offset, friction and reason."""
    def answer_of(task):
        wrong = isinstance(task, PlaneTrial) and task.spec.friction == 0.6 and "box" in task.ground.name
        return FELL if wrong and task.spec.seed == 1 else ARRIVED

    rows = evaluated("steps", answer_of, in_space=False)["results"]
    assert len(rows) == 15
    for row in rows:
        failed = [{"offset_m": 0.05, "friction": 0.6, "reason": "fell at 3.00 s"}] if row["kind"] == "box" else []
        assert row == {"height_m": row["height_m"], "kind": row["kind"], "gait": "paper-trot",
                       "passed": 4 - len(failed), "trials": 4, "failures": failed, "three_d": None}


def test_table2_json_is_as_promised():
    cases = evaluated("table2", lambda task: ARRIVED)["cases"]
    assert len(cases) == 4
    for case in cases:
        assert {"name", "n", "speed_m_s", "pitch_range_deg", "paper"} <= set(case)
        assert case["speed_m_s"] == {"mean": 0.04, "sd": 0.0}
        assert case["roll_range_deg"] == {"mean": 4.5, "sd": 0.0}


def test_a_case_in_which_nobody_arrives_has_no_figures():
    case = evaluated("table2", lambda task: FELL)["cases"][0]
    assert case["passed"] == 0
    assert case["speed_m_s"] is None


def test_requirements_are_met_or_not_by_their_figures():
    met = [row["met"] for row in evaluated("requirements", lambda task: ARRIVED)["requirements"]]
    assert met == [False] + [True] * 7  # at 0.04 m/s and 30 W the battery is empty before 50 m2
    failed = [row["met"] for row in evaluated("requirements", lambda task: FELL)["requirements"]]
    assert failed == [False, False, False, False, True, False, True, False]


# --- the command


class Arrives:
    def run(self):
        return ARRIVED


def test_a_line_a_case_tells_on_stderr_how_far_it_is(run, monkeypatch):
    """Minutes of silence were taken for a hang when the output went into a file."""
    from host.lab.experiments import steps

    monkeypatch.setattr(steps, "tasks", lambda options: [Arrives()] * 3)
    monkeypatch.setattr(steps, "evaluate", lambda options, answers: Outcome("steps", "", {"trials": len(answers)}, []))
    code, out, err = run("experiment", "steps", "--gait", "crawl", "--json")
    assert (code, json.loads(out)) == (0, {"trials": 3})
    assert err.splitlines()[-3:] == [f"steps (crawl): {number} of 3" for number in (1, 2, 3)]


def test_table1_prints_one_object_and_writes_whole_files(run, tmp_path):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed (extra sim)")
    code, out, _ = run("experiment", "table1", "--trials", "2", "--no-3d", "--json", "--out", str(tmp_path / "new"))
    assert code == 0
    result = json.loads(out)
    assert [case["target_m"] for case in result["cases"]] == [[0.05, 0.03], [0.03, 0.05]]
    assert result["cases"][0]["three_d"] is None
    assert result["cases"][0]["paper"]["z_max_m"]["mean"] == 0.047568
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["report.html", "table1.json", "table1.png"]
    assert json.loads((tmp_path / "new" / "table1.json").read_text()) == result
    page = (tmp_path / "new" / "report.html").read_text()
    assert "data:image/png;base64," in page
    assert "src=\"http" not in page


def test_wrong_words_are_told_in_one_line(run):
    for arguments, told in (
        (("experiment", "table3"), "there are table1, table2"),
        (("experiment", "ramp", "--gait", "gallop"), "no such gait"),
        (("export", "mjcf", "--terrain", "moon"), "no such ground"),
        (("export", "urdf", "--voltage", "40"), "allowed 11.1 .. 14.8 V"),
        (("export", "urdf", "--json"), "--out FILE"),
    ):
        code, out, err = run(*arguments)
        assert code == 2
        assert out == ""
        assert told in err
        assert err.count("\n") == 1


def test_without_mujoco_the_plane_goes_on(run, monkeypatch):
    from host.lab.experiments import trials

    monkeypatch.setattr(trials, "find_spec", lambda name: None)
    code, out, err = run("experiment", "table1", "--trials", "2", "--json")
    assert code == 0
    assert "3-D columns stay empty" in err
    assert json.loads(out)["cases"][0]["three_d"] is None


def test_export_writes_the_files(run, tmp_path):
    for kind, robot in (("mjcf", "caramelo"), ("urdf", "parallel")):
        target = tmp_path / f"{robot}.xml"
        code, out, _ = run("export", kind, "--robot", robot, "--payload", "1", "--out", str(target), "--json")
        assert code == 0
        assert json.loads(out) == {"robot": robot, "format": kind, "file": str(target),
                                   "bytes": len(target.read_bytes())}


def children_of(pid):
    """Return the numbers of a process's children."""
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


def test_ctrl_c_leaves_nothing_half_written(tmp_path):
    """Interrupted while trials run in two processes: exit code 130, one line, no file."""
    target = tmp_path / "out"
    process = subprocess.Popen(
        [CARAMELO, "experiment", "ramp", "--gait", "paper-trot", "--jobs", "2", "--no-3d", "--out", target],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=hear_ctrl_c,
    )
    wait_until(lambda: len(children_of(process.pid)) >= 2, "trials begin")
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    told = err.splitlines()
    assert told.pop() == "caramelo: stopped by Ctrl-C"
    assert all(line.startswith("ramp (paper-trot): ") for line in told)
    assert out == ""
    assert not target.exists()


@pytest.mark.slow
@pytest.mark.skipif(not has_mujoco(), reason="MuJoCo is not installed (extra space)")
def test_all_experiments_run(run, tmp_path):
    """Everything once, one trial each, in both simulators."""
    code, out, _ = run("experiment", "all", "--gait", "paper-trot", "--trials", "1", "--jobs", "2", "--json",
                       "--out", str(tmp_path))
    assert code == 0
    result = json.loads(out)
    assert set(result) == {"table1", "table2", "ramp", "steps", "payload", "requirements"}
    assert {row["kind"] for row in result["steps"]["results"]} == {"up", "down", "box"}
    assert len(result["requirements"]["requirements"]) == 8
    assert (tmp_path / "report.html").stat().st_size > 100_000
