"""`caramelo experiment` and `caramelo export`: figures that depend on no timing, whole files, plain errors."""

import json
import math
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from host.lab.experiments import counts, drawn, goals, requirements, run, samples
from host.lab.experiments.case import Case, Found, Row
from host.lab.experiments.data import assumptions, papers
from host.lab.experiments.foot_in_air import AirTrial
from host.lab.experiments.run import EXPERIMENTS
from host.lab.experiments.trials import PLANE, SPACE, STRIDE_M, Answer, Options, Trial, trial_conditions, with_knees
from host.lab.experiments.verdicts import everywhere, share, within
from host.lab.workers.work import Here, workers
from host.robot.ability import ability, cannot
from host.robot.file import load_robot
from host.robot.trot_tuning import GAIT
from host.sim.walk import WalkSpec
from tests import ROOT
from tests.processes import children_of, hear_signals
from tests.shared.robots import with_trunk_at
from tests.waiting import PATIENCE_S, wait_until

ROBOT = load_robot("caramelo")
CARAMELO = Path(sys.executable).parent / "caramelo"


# --- statistics


def test_the_papers_t_tests_are_reproduced():
    """The paper's printed p of table 1 are two-sided Student; those of table 2 one-sided, of the roll range."""
    table = papers()["table1"]
    for quantity, printed in table["printed_p"].items():
        first, second = (samples.published(table["trials"], case[quantity]) for case in table["case"])
        assert samples.t_test(first, second) == pytest.approx(printed, abs=5e-4)
    cases = papers()["table2"]["case"]
    for at, ground in ((0, "flat"), (2, "stones")):
        first, second = (samples.published(case["n"], case["roll_range_deg"]) for case in cases[at : at + 2])
        assert samples.t_test(first, second) / 2 == pytest.approx(papers()["table2"]["printed_p"][ground], rel=0.02)


def test_a_t_test_of_values_is_scipys():
    from scipy import stats

    a, b = [1.0, 2.0, 4.0, 4.5], [2.5, 3.5, 5.0, 6.0, 7.5]
    assert samples.t_test(samples.sample(a), samples.sample(b)) == pytest.approx(stats.ttest_ind(a, b).pvalue, rel=1e-3)


def test_no_p_value_where_nothing_varies():
    same = samples.sample([1.0, 1.0, 1.0])
    assert samples.t_test(same, samples.sample([2.0, 2.0])) is None
    assert samples.t_test(samples.sample([1.0]), samples.sample([2.0, 3.0])) is None


# --- requirements


def test_inspecting_takes_longer_and_more_when_slower():
    """Judged by the simulator that needs more; 15 lanes of 7.07 m, turning between them at 1.2 rad/s."""
    def walked(speed_m_s, power_W):
        walk = Answer({"ok": True, "mean_speed_m_s": speed_m_s, "power_W": power_W})
        easy = Answer({"ok": True, "mean_speed_m_s": 0.2, "power_W": 1.0})
        return requirements.inspection(ROBOT, {"plane": [easy], "3-D": [walk]})

    assert requirements.coverage(ROBOT, 0.05, 20.0)["time_s"] == round(15 * 50**0.5 / 0.05 + 14 * math.pi / 1.2)
    met, told = walked(0.05, 20.0)
    assert met
    assert "(3-D)" in told
    assert not walked(0.01, 20.0)[0]
    assert not walked(0.05, 200.0)[0]
    assert not requirements.inspection(ROBOT, {"plane": [Answer({"ok": False})]})[0]


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
    assert Trial(WalkSpec(robot, "paper-trot", distance_m=0.05)).run().ok


@pytest.mark.parametrize("where", [PLANE, SPACE])
def test_a_robot_that_falls_before_its_first_tick_has_figures(where):
    """Its centre of mass is far behind its feet, so in space the recording is a single row."""
    if where == SPACE:
        pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
    figures = Trial(WalkSpec(with_trunk_at("caramelo", (-0.2, 0.0, 0.0)), GAIT), where).run().figures
    assert (figures["ok"], figures["falls"]) == (False, 1)
    assert math.isfinite(figures["joint_acceleration_rad_s2"])


def test_offsets_go_across_a_stride_at_both_frictions():
    tried = Options(ROBOT, "trot").starts(10)
    assert len(tried) == 20
    assert len({offset for offset, _, _ in tried}) == 10
    assert {friction for _, friction, _ in tried} == {0.6, 0.9}
    assert max(offset for offset, _, _ in tried) < STRIDE_M


def test_the_held_out_set_shares_no_seed_and_no_offset_with_the_chosen_one():
    """Whatever the numbers of trials of the two are."""
    chosen, held_out = (
        [start for count in range(1, 41) for start in Options(ROBOT, "trot", held_out=held).starts(count)]
        for held in (False, True)
    )
    for part in (0, 2):
        assert not {start[part] for start in chosen} & {start[part] for start in held_out}


def test_answers_are_the_same_for_any_number_of_jobs():
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    heard, found = [], []
    for jobs in (1, 2):
        with workers(jobs) as run_by:
            outcome = run.run_experiment("table1", Options(ROBOT, "paper-trot", trials=2, in_space=False), run_by,
                                         lambda done, count, _: heard.append(done))
        found.append(outcome.found.result)
    assert found[0] == found[1]
    assert heard == [1, 2, 3, 4] * 2


def test_the_foot_in_the_air_is_as_measured():
    """Without the hip: highest point and time as the real robot's (paper: 47.6 mm; median time 0.557 s)."""
    case = AirTrial(ROBOT, (0.05, 0.0), {"voltage_V": 12.0, "bus_delay_s": 0.02}, in_space=False).run().figures
    assert case["z_max_m"] == pytest.approx(0.0476, abs=0.001)
    assert case["time_s"] == pytest.approx(0.557, abs=0.015)
    assert case["x_final_m"] == pytest.approx(0.05, abs=0.001)


CANNED = {
    "mean_speed_m_s": 0.04, "speed_m_s": 0.041, "pitch_range_deg": 3.0, "roll_range_deg": 4.0, "power_W": 30.0,
    "whole_pitch_range_deg": 3.5, "whole_roll_range_deg": 4.5, "yaw_drift_deg": 1.0, "side_drift_m": 0.01,
    "torque_rms_fraction": {"FR_calf": 0.3, "FR_thigh": 0.35}, "gait_changes": [], "falls": 0, "crossing_s": 5.0,
    "cost_of_transport": 1.0, "reason": "arrived", "seed": 0, "start_m": 0.35, "friction": 0.6,
}
ARRIVED = Answer({**CANNED, "ok": True})
FELL = Answer({**CANNED, "ok": False, "falls": 1, "crossing_s": None, "reason": "fell at 3.00 s"})


def summed_up(name, answer_of, in_space=True, **more):
    """Return an experiment's figures for made-up answers, one for each of its trials."""
    options = Options(ROBOT, "paper-trot", trials=2, in_space=in_space, **more)
    rows = [Row(case, {where: [answer_of(trial) for trial in series] for where, series in case.trials.items()})
            for case in EXPERIMENTS[name].cases(options)]
    found = EXPERIMENTS[name].sum_up(options, rows)
    json.dumps(found.result, allow_nan=False)
    for table in found.tables:
        assert all(len(row) == len(table.head) for row in table.rows), table.title
        assert all(isinstance(cell, str) for row in table.rows for cell in row), table.title
    return found.result


@pytest.mark.parametrize("in_space", [True, False])
@pytest.mark.parametrize("name", ["table2", "ramp", "steps", "payload", "requirements", "goals"])
def test_every_experiment_sums_up_success_and_failure(name, in_space):
    assert summed_up(name, lambda trial: ARRIVED, in_space) != summed_up(name, lambda trial: FELL, in_space)


def test_a_failed_step_tells_where_it_started_and_why():
    """One failure in one kind: counts, and the failure's seed, start, friction and reason."""
    def answer_of(trial):
        spec = trial.spec
        wrong = spec.ground.name == "box" and (spec.friction, spec.seed) == (0.6, 1)
        return replace(FELL, figures={**FELL.figures, "seed": 1, "start_m": spec.ground.start_m}) if wrong else ARRIVED

    rows = summed_up("steps", answer_of, in_space=False)["results"]
    assert len(rows) == 15
    failure = {"seed": 1, "start_m": 0.35, "friction": 0.6, "reason": "fell at 3.00 s"}
    for row in rows:
        failed = [failure] if row["kind"] == "box" else []
        plane = row["plane"]
        assert (plane["passed"], plane["trials"], plane["failures"]) == (4 - len(failed), 4, failed)
        assert row["three_d"] is None


def test_table2_has_a_sample_of_every_figure_of_those_that_arrived():
    cases = summed_up("table2", lambda trial: ARRIVED)["cases"]
    assert [case["case"] for case in cases] == [case["name"] for case in papers()["table2"]["case"]]
    for case in cases:
        assert case["plane"]["speed_m_s"] == {"mean": 0.04, "sd": 0.0}
        assert case["three_d"]["roll_range_deg"] == {"mean": 4.5, "sd": 0.0}
        assert case["paper"]["roll_range_deg"]["mean"] > 5
    fallen = summed_up("table2", lambda trial: FELL)["cases"][0]["plane"]
    assert (fallen["passed"], fallen["speed_m_s"]) == (0, None)


def test_requirements_are_met_or_not_by_their_figures():
    """At 0.04 m/s and 30 W the battery is empty before 50 m2; mass and torque need no walk."""
    met = [row["met"] for row in summed_up("requirements", lambda trial: ARRIVED)["rows"]]
    assert met == [False] + [True] * 7
    failed = [row["met"] for row in summed_up("requirements", lambda trial: FELL)["rows"]]
    assert failed == [False, False, False, False, True, False, True, False]


def test_a_case_is_judged_by_its_limits():
    """The judges can say no: to a fall, to a figure outside, to one failure in ten, to who is too slow."""
    slow = Answer({**ARRIVED.figures, "speed_m_s": 0.03, "crossing_s": 7.0})
    judge = within(speed_m_s=(0.04, 0.05))
    assert [judge({"3-D": [answer]})[0] for answer in (ARRIVED, slow, FELL)] == [True, False, False]
    assert within(judged=False, speed_m_s=(0.04, 0.05))({"3-D": [FELL]})[0] is None
    nowhere = Answer({**FELL.figures, "cost_of_transport": None})
    assert within(cost_of_transport=(0, 1.6))({"3-D": [nowhere]}) == (False, "0/1, no cost")
    assert share(0.95)({"3-D": [ARRIVED] * 19 + [FELL]})[0] is True
    assert share(0.95)({"3-D": [ARRIVED] * 9 + [FELL]})[0] is False
    assert share(None)({"3-D": [FELL]})[0] is None
    assert share(0.5, most_median=("crossing_s", 6.0))({"3-D": [ARRIVED, FELL]})[0] is True
    assert share(0.5, most_median=("crossing_s", 6.0))({"3-D": [slow, FELL]})[0] is False
    assert share(0.5, most_median=("crossing_s", 6.0))({"3-D": [FELL]}) == (False, "0/1, no median")
    assert everywhere({"plane": [ARRIVED], "3-D": [ARRIVED, FELL]}) == (False, "1/1 plane, 1/2 3-D")


def test_a_step_taken_by_the_crawl_is_not_taken_at_a_trot():
    crawled = Answer({**ARRIVED.figures, "gait_changes": [{"to": "crawl"}]})
    assert goals.at_a_trot(ARRIVED)
    assert not goals.at_a_trot(crawled)
    assert not goals.at_a_trot(FELL)


def test_a_push_that_is_walked_off_is_no_failure():
    """Nobody waits for the walk's end: it is watched for four seconds."""
    walks_on = Answer({**ARRIVED.figures, "ok": False, "reason": "timed out"})
    options = Options(ROBOT, "trot", 1, only=("pushes",))
    rows = [Row(case, {"3-D": [walks_on, FELL]}) for case in goals.cases(options)]
    for row in EXPERIMENTS["goals"].sum_up(options, rows).result["rows"]:
        assert (row["figure"], row["failures"]) == ("1/2", ["fell at 3.00 s"])


def test_a_load_that_is_too_much_to_stand_with_is_not_a_goal():
    """In the plane no joint may need 40 % of stall: Parallel needs 55 % to stand with its load, Caramelo 39 %."""
    for name, met, wanted in (("parallel", None, "to stand with it takes 55 % of stall"), ("caramelo", True, "40 %")):
        (case,) = goals.load(Options(load_robot(name), "trot"), goals.wanted(load_robot(name), "trot"), PLANE)
        assert wanted in case.wanted
        assert case.judge({PLANE: [ARRIVED] * len(case.trials[PLANE])})[0] is met


def test_any_robot_has_its_goals():
    """One that no table names has them by its size and its gait's own limit; groups can be asked for one by one."""
    stranger = ROBOT.model_copy(update={"name": "stranger"})
    want, own = (goals.wanted(robot, "trot") for robot in (stranger, ROBOT))
    assert (own.flat_m_s, own.step_m, own.table["push_least"]) == (0.30, 0.05, 0.95)
    assert want.flat_m_s == pytest.approx(min(0.25 * math.sqrt(9.81 * 0.17), 0.30), rel=0.01)
    assert want.step_m == pytest.approx(0.16 * 0.24)
    rows = goals.cases(Options(stranger, "trot", 1, only=("steps", "stairs")))
    assert {row.facts["group"] for row in rows} == {"steps", "stairs"}
    assert goals.cases(Options(ROBOT, "trot", 1, in_space=False, only=("steps",))) == []


def test_a_trial_of_two_cases_runs_once(monkeypatch):
    class Counts:
        ran = 0

        def run(self):
            Counts.ran += 1
            return ARRIVED

    trial = Counts()
    both = [Case(name, {PLANE: [trial]}) for name in ("one", "two")]
    made = replace(EXPERIMENTS["goals"], cases=lambda options: both, sum_up=lambda options, rows: Found(
        {"answers": [answer.ok for row in rows for answer in row.answers[PLANE]]}, []))
    monkeypatch.setitem(EXPERIMENTS, "goals", made)
    outcome = run.run_experiment("goals", Options(ROBOT, "trot"), Here(), lambda done, count, _: None)
    assert (outcome.found.result["answers"], Counts.ran) == ([True, True], 1)


# --- the command


class Arrives:
    def run(self):
        return ARRIVED


def test_a_line_a_case_tells_on_stderr_how_far_it_is(run_json, monkeypatch):
    """Minutes of silence were taken for a hang when the output went into a file."""
    cases = [Case("steps", {PLANE: [Arrives() for _ in range(3)]})]
    made = replace(EXPERIMENTS["steps"], cases=lambda options: cases, sum_up=lambda options, rows: Found({}, []))
    monkeypatch.setitem(EXPERIMENTS, "steps", made)
    code, found, err = run_json("experiment", "steps", "--gait", "crawl")
    assert (code, found) == (0, {"experiment": "steps", "robot": "caramelo", "gait": "crawl", "honest": True})
    assert err.splitlines()[-3:] == [f"steps (crawl): {number} of 3" for number in (1, 2, 3)]


def test_a_gait_file_is_a_gait_here_too(run_json, monkeypatch):
    """Whoever wrote a gait could walk it, but not compare it with the others."""
    made = replace(EXPERIMENTS["steps"], cases=lambda options: [], sum_up=lambda options, rows: Found({}, []))
    monkeypatch.setitem(EXPERIMENTS, "steps", made)
    code, found, _ = run_json("experiment", "steps", "--gait", str(ROOT / "examples/amble.toml"))
    assert (code, found["gait"]) == (0, "amble")


def test_table1_prints_one_object_and_writes_whole_files(run_json, tmp_path):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed (extra sim)")
    code, result, _ = run_json("experiment", "table1", "--trials", "2", "--no-3d", "--out", str(tmp_path / "new"))
    assert code == 0
    assert [case["case"] for case in result["cases"]] == ["to x 0.05, y 0.03 m", "to x 0.03, y 0.05 m"]
    assert result["cases"][0]["three_d"] is None
    assert result["cases"][0]["paper"]["z_max_m"]["mean"] == 0.047568
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["report.html", "table1.json", "table1.png"]
    assert json.loads((tmp_path / "new" / "table1.json").read_text()) == result
    page = (tmp_path / "new" / "report.html").read_text()
    assert "data:image/png;base64," in page
    assert "src=\"http" not in page


def test_goals_print_one_object_with_a_row_for_each_case(run_json):
    """Sideways, turning and backwards, each at both frictions: the trot does what it is told."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
    code, result, _ = run_json("experiment", "goals", "--only", "ways", "--set", "held-out", "--trials", "1")
    assert (code, result["gait"], len(result["rows"])) == (0, GAIT, 3)
    for row in result["rows"]:
        assert (row["group"], row["in"], row["met"], row["walks"]) == ("ways", ["3-D"], True, 2)
        assert row["figure"].startswith("2/2, speed")


def test_drawn_robots_are_always_the_same_and_pass_the_check():
    """By their seeds: other ones are held out. Each is one that the check lets through, and walks in the gait asked."""
    def names(**more):
        return [robot.name for robot in drawn.robots(Options(ROBOT, GAIT, 3, **more))]

    assert names() == names() == ["drawn-0", "drawn-1", "drawn-2"]
    assert set(names(held_out=True)).isdisjoint(f"drawn-{seed}" for seed in range(1000))
    for robot in drawn.robots(Options(ROBOT.simulated(False), GAIT, 3)):
        assert not list(cannot(robot, ability(robot)))
        assert not robot.simulation.honest
        gaits = {name: walk.gait for name, walk in drawn.walks(robot, "paper-trot").items()}
        assert gaits.pop("in the crawl") == "crawl"
        assert set(gaits.values()) == {"paper-trot"}


def test_walks_of_drawn_robots_are_counted_and_failures_named(run_json, tmp_path):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
    code, result, _ = run_json("experiment", "drawn", "--trials", "2", "--out", str(tmp_path))
    assert "<h1>Experiments: drawn, gait trot</h1>" in (tmp_path / "report.html").read_text()
    assert (code, result["robot"], len(result["rows"])) == (0, "drawn", 8)
    for row in result["rows"]:
        assert (row["in"], row["met"], row["walks"]) == (["3-D"], None, 2)
        assert row["figure"] == f"{2 - len(row['failures'])}/2"
        assert set(row["failures"]) <= {"drawn-0", "drawn-1"}
    assert result["rows"][0]["figure"] == "2/2"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("experiment table3", "there are table1, table2"),
        ("experiment ramp --gait gallop", "no such gait"),
        ("experiment ramp --gait gallop.toml", "no such file"),
        ("experiment ramp --only flat", "only with experiment goals; ramp has no groups"),
        ("experiment goals --only flat,moon", "there are flat, conditions"),
        ("experiment goals --set best", "allowed chosen or held-out"),
        ("experiment drawn --robot parallel", "not with experiment drawn"),
        ("experiment drawn --no-3d", "all in three dimensions"),
        ("export mjcf --terrain moon", "--terrain moon: allowed flat"),
        ("export urdf --voltage 40", "allowed 11.1 .. 14.8 V"),
        ("export urdf --json", "--out FILE"),
    ],
)
def test_wrong_words_are_told_in_one_line(refused, arguments, told):
    assert told in refused(*arguments.split())


def test_without_mujoco_the_plane_goes_on(run_json, monkeypatch):
    from host.lab.experiments import trials

    monkeypatch.setattr(trials, "find_spec", lambda name: None)
    code, result, err = run_json("experiment", "table1", "--trials", "2")
    assert (code, result["cases"][0]["three_d"]) == (0, None)
    assert "3-D columns stay empty" in err


@pytest.mark.parametrize(("kind", "robot"), [("mjcf", "caramelo"), ("urdf", "parallel")])
def test_export_writes_the_file(run_json, tmp_path, kind, robot):
    target = tmp_path / f"{robot}.xml"
    code, told, _ = run_json("export", kind, "--robot", robot, "--payload", "1", "--out", str(target))
    assert code == 0
    assert told == {"robot": robot, "format": kind, "file": str(target), "bytes": len(target.read_bytes())}


@pytest.mark.parametrize(("number", "children", "last"), [
    (signal.SIGINT, 3, "stopped by Ctrl-C"), (signal.SIGTERM, 2, "stopped by SIGTERM"),
])  # fmt: skip
def test_a_signal_leaves_nothing_half_written(tmp_path, number, children, last):
    """While trials run in two processes (and Python's own helper), or one of these still starts: one line, no file."""
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    target = tmp_path / "out"
    process = subprocess.Popen(
        [CARAMELO, "experiment", "ramp", "--gait", "paper-trot", "--jobs", "2", "--no-3d", "--out", target],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=hear_signals,
    )
    wait_until(lambda: len(children_of(process.pid)) >= children, "the workers")
    os.killpg(process.pid, number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 128 + number
    told = err.splitlines()
    assert told.pop() == f"caramelo: {last}"
    assert all(line.startswith("ramp (paper-trot): ") for line in told)
    assert out == ""
    assert not target.exists()


@pytest.mark.slow
def test_all_experiments_run(run_json, tmp_path):
    """Everything once, one trial each, in both simulators."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
    code, result, _ = run_json("experiment", "all", "--gait", "paper-trot", "--trials", "1", "--jobs", "2",
                               "--out", str(tmp_path))
    assert code == 0
    assert set(result) == {"table1", "table2", "ramp", "steps", "payload", "requirements"}
    assert {row["kind"] for row in result["steps"]["results"]} == set(counts.STEPS)
    assert len(result["requirements"]["rows"]) == 8
    assert (tmp_path / "report.html").stat().st_size > 100_000
