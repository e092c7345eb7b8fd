"""Tuning gets back what was spoiled: a robot file whose chosen values are 30 % off, against the file as it was."""

from itertools import cycle

import pytest

pytest.importorskip("cma", reason="cma is not installed (extra lab)")
pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")

from host.lab.tune.goals import OTHER_SEEDS, walks
from host.lab.tune.values import RobotFile
from host.lab.workers.work import workers
from host.robot.file import load_robot
from host.robot.rewrite import NewValue, rewritten

BACK, SPOILED = 0.95, 0.30


def spoiled(name, speed, folder):
    """Return the path of a copy in which what is searched is 30 % too large and too small in turn."""
    file, signs = RobotFile(name), cycle((1, -1))
    values = {each.key: NewValue(each.at((each.now * (1 + SPOILED * next(signs)) - each.low) / (each.high - each.low)),
                                 each.meaning) for each in file.searched(file.robot.gait.default, speed)}
    path = folder / "spoiled.toml"
    path.write_text(rewritten(file.text, values, "chosen"))
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("name", "goal", "trials"), [("solo12", "speed", 200), ("solo12", "quiet", 56)])
def test_it_gets_back_what_was_spoiled(run_json, tmp_path, name, goal, trials):
    bad = spoiled(name, goal == "speed", tmp_path)
    robot = load_robot(name)
    with workers(2) as run_by:
        scores = run_by.run_all(walks(goal, robot, robot.gait.default, "3-D", OTHER_SEEDS, {}), lambda done: None)
    unspoiled = sum(scores) / len(scores)
    code, found, _ = run_json("tune", "--robot", str(bad), "--for", goal, "--trials", str(trials), "--jobs", "2",
                              "--out", str(tmp_path / "tuned.toml"))
    before, after = (found["other_grounds"][when] for when in ("before", "after"))
    print(f"{name} for {goal}: {unspoiled:.4g}, spoiled {before:.4g}, tuned {after:.4g} {found['unit']}")
    assert code == 0
    assert before < BACK * unspoiled, "else nothing was spoiled"
    assert after >= BACK * unspoiled
