"""`caramelo tune` as a whole: a copy of the file that is better, or none; the same for any number of workers."""

import json
from pathlib import Path

import pytest

pytest.importorskip("cma", reason="cma is not installed (extra lab)")

from host.commands.tune import GOALS
from host.lab.tune import goals
from host.lab.tune import run as tuning
from host.lab.tune.values import RobotFile
from host.lab.workers.work import Here
from host.robot.file import load_robot
from host.robot.rewrite import sources

ROBOT = "caramelo"


@pytest.fixture
def short(monkeypatch):
    """Two short walks a trial, in the plane."""
    monkeypatch.setattr(goals, "WALK_S", 2.0)
    monkeypatch.setattr(tuning, "SEARCHED_SEEDS", range(2))
    monkeypatch.setattr(tuning, "FINAL_SEEDS", range(500, 501))
    monkeypatch.setattr(tuning, "OTHER_SEEDS", range(1000, 1002))


def tuned(run, out, *more):
    code, told, err = run("tune", "--robot", ROBOT, "--for", "quiet", "--in", "plane", "--trials", "12",
                          "--out", str(out), "--json", *more)
    return code, json.loads(told) if told else None, err


def test_a_copy_is_written_with_what_was_found_and_its_score(short, run, tmp_path):
    out = tmp_path / "new.toml"
    code, result, err = tuned(run, out)
    assert (code, result["ok"], result["file"], result["trials"]) == (0, True, str(out), 12)
    assert result["searched"]["after"] > result["searched"]["before"]
    assert result["other_grounds"]["after"] > result["other_grounds"]["before"]
    assert err.splitlines()[-3].startswith("tuning caramelo for quiet: 12 of 12: best ")
    robot, text = load_robot(str(out)), out.read_text()
    assert robot.trot["low_lift"] == result["values"]["trot.low_lift"]["after"]
    assert sources(text)["trot.low_lift"] == "tuned"
    assert sources(text)["links.trunk.mass_kg"] != "tuned"
    assert len(Path(result["store"]).read_text().splitlines()) == 13


def test_two_processes_find_the_same_and_so_does_going_on(short, run, tmp_path):
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    one, two, on = (tmp_path / f"{name}.toml" for name in ("one", "two", "on"))
    assert tuned(run, one)[0] == tuned(run, two, "--jobs", "2")[0] == 0
    store = one.with_suffix(".trials.jsonl").read_text()
    assert two.with_suffix(".trials.jsonl").read_text() == store
    on.with_suffix(".trials.jsonl").write_text("".join(store.splitlines(keepends=True)[:6]))
    assert tuned(run, on)[0] == 0
    assert one.read_text() == two.read_text() == on.read_text()


def test_ctrl_c_keeps_the_best_and_the_same_command_goes_on(short, run, tmp_path, monkeypatch):
    out, real = tmp_path / "new.toml", tuning.Tuning.scores

    def stopped(self, candidates, seeds, told):
        if len(self.store.trials) >= 10:
            raise KeyboardInterrupt
        return real(self, candidates, seeds, told)

    monkeypatch.setattr(tuning.Tuning, "scores", stopped)
    code, result, err = tuned(run, out)
    assert (code, result) == (130, None)
    assert f"the best of 10 trials so far is in {out}, not compared on other grounds yet; the same command" in err
    assert err.splitlines()[-1] == "caramelo: stopped by Ctrl-C"
    assert sources(out.read_text())["trot.low_lift"] == "tuned"
    monkeypatch.setattr(tuning.Tuning, "scores", real)
    code, result, _ = tuned(run, out)
    assert (code, result["trials"]) == (0, 12)


def test_who_does_best_on_more_walks_is_chosen_not_who_was_lucky(short, tmp_path, monkeypatch):
    file = RobotFile(ROBOT)
    wanted = tuning.Wanted(file, "quiet", file.robot.gait.default, "plane", 12)
    found = tuning.Tuning(wanted, tmp_path / "trials.jsonl", Here(), lambda done, best: None)
    for low_lift, score in ((0.08, 0.5), (0.09, 0.9), (0.10, 0.8), (0.09, 0.9), (0.11, 0.1)):
        found.store.add({"trot.low_lift": low_lift}, score)
    assert found.best == ({"trot.low_lift": 0.09}, 0.9)
    asked = []

    def scores(candidates, seeds, told):
        asked.extend(values["trot.low_lift"] for values in candidates)
        return [{0.09: 0.4, 0.10: 0.8}.get(values["trot.low_lift"], 0.0) for values in candidates]

    monkeypatch.setattr(found, "scores", scores)
    found.final()
    assert asked == [0.09, 0.10, 0.08, 0.11]
    assert found.best == ({"trot.low_lift": 0.10}, 0.8)


def test_what_is_no_better_elsewhere_is_not_written(short, run, tmp_path, monkeypatch):
    monkeypatch.setattr(tuning.Tuning, "on_other_grounds", lambda self: (1.0, 1.0))
    out = tmp_path / "new.toml"
    code, result, _ = tuned(run, out)
    assert (code, result["ok"], result["file"]) == (1, False, None)
    assert not out.exists()


def test_the_command_knows_every_goal():
    assert tuple(goals.GOALS) == GOALS


def test_wrong_words_are_told_in_one_line(refused, tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text("")
    for arguments, told in (
        (("--for", "beauty"), "--for beauty: allowed speed, steps, payload, quiet"),
        (("--in", "moon"), "--in moon: allowed plane, space"),
        (("--gait", "gallop"), "no such gait"),
        (("--gait", "amble.toml"), "put the file's keys into [[gait.own]]"),
        (("--robot", "nobody"), "unknown"),
        (("--robot", ROBOT, "--out", str(mine)), "the file exists and comes from no search in"),
    ):
        assert told in refused("tune", *arguments)
    assert mine.read_text() == ""
