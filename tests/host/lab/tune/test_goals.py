"""What a robot is tuned for: a better walk scores higher, a fall costs; seeds differ, what searched judges nothing."""

from dataclasses import replace

import pytest

from host.lab.experiments.trials import PLANE, SPACE, Answer, Trial
from host.lab.tune.goals import FALL, FINAL_SEEDS, GOALS, OTHER_SEEDS, SEARCHED_SEEDS, ScoredWalk, walks
from host.robot.file import load_robot, robot_names
from host.util.errors import NOT_ACHIEVED, WRONG_USE, UserError

ROBOT = load_robot("solo12")
WALKED = {"distance_m": 0.5, "falls": 0, "joint_acceleration_rad_s2": 50.0, "torque_rms_fraction": {"FR_calf": 0.2}}


def score(goal, monkeypatch, seed=0, **figures):
    monkeypatch.setattr(Trial, "run", lambda trial: Answer(WALKED | figures))
    (walk,) = walks(goal, ROBOT, ROBOT.gait.default, SPACE, range(seed, seed + 1), {})
    return walk.run()


@pytest.mark.parametrize("goal", GOALS)
def test_a_longer_way_scores_higher_and_a_fall_costs_most_of_it(goal, monkeypatch):
    assert score(goal, monkeypatch, distance_m=0.2) < score(goal, monkeypatch)
    assert score(goal, monkeypatch, falls=1) == FALL * score(goal, monkeypatch)
    assert score(goal, monkeypatch, distance_m=-0.1) == 0.0


def test_each_goal_counts_what_it_is_named_for(monkeypatch):
    assert score("speed", monkeypatch, distance_m=4.0) == 0.4
    assert score("steps", monkeypatch, distance_m=5.0) == 1.0
    assert score("quiet", monkeypatch, joint_acceleration_rad_s2=25.0) == 2 * score("quiet", monkeypatch)
    hot = {"FR_calf": 0.8}
    assert score("payload", monkeypatch, torque_rms_fraction=hot) == score("payload", monkeypatch) / 2
    assert score("payload", monkeypatch, seed=2) == pytest.approx(2 * score("payload", monkeypatch))


def test_a_robot_that_does_not_stand_up_scores_nothing(monkeypatch):
    def refused(exit_code):
        def run(trial):
            raise UserError("the robot does not stand", exit_code)

        monkeypatch.setattr(Trial, "run", run)
        return walks("speed", ROBOT, ROBOT.gait.default, SPACE, range(1), {})[0].run()

    assert refused(NOT_ACHIEVED) == 0.0
    with pytest.raises(UserError):
        refused(WRONG_USE)


@pytest.mark.parametrize("goal", GOALS)
def test_every_seed_is_another_walk_and_none_is_searched_and_judged(goal):
    assert len({*SEARCHED_SEEDS, *FINAL_SEEDS, *OTHER_SEEDS}) == 8 + 16 + 16
    made = [walk.trial.spec for seeds in (SEARCHED_SEEDS, OTHER_SEEDS)
            for walk in walks(goal, ROBOT, ROBOT.gait.default, SPACE, seeds, {})]
    told = {(spec.friction, spec.bus_delay_s, spec.voltage_V, spec.built.actuator.stiffness_Nm_rad,
             spec.built.actuator.coulomb_Nm) for spec in made}
    assert len(told) == len(made)
    assert len({spec.ground for spec in made}) >= len(made) / 2
    assert all(0.6 <= spec.friction <= 0.95 and 0.01 <= spec.bus_delay_s <= 0.04 for spec in made)
    assert walks(goal, ROBOT, ROBOT.gait.default, SPACE, SEARCHED_SEEDS, {}) == walks(
        goal, ROBOT, ROBOT.gait.default, SPACE, SEARCHED_SEEDS, {})


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_has_walks_for_every_goal(name):
    robot = load_robot(name)
    for goal in GOALS:
        for walk in walks(goal, robot, robot.gait.default, PLANE, SEARCHED_SEEDS, {}):
            assert walk.trial.spec.built != robot


def test_the_robot_as_built_walks_otherwise_than_the_file_says():
    (walk,) = walks("quiet", ROBOT, ROBOT.gait.default, PLANE, range(1), {})

    def gone(built):
        spec = replace(walk.trial.spec, built=built, limit_s=2.0)
        return ScoredWalk("quiet", Trial(spec, PLANE)).run()

    assert gone(walk.trial.spec.built) != gone(None)


def test_the_spread_that_a_file_tells_takes_the_place_of_the_assumed_one():
    def most(spreads):
        made = [walk.trial.spec for walk in walks("quiet", ROBOT, ROBOT.gait.default, PLANE, range(20), spreads)]
        drives = [(spec.built.actuator, spec.robot.actuator) for spec in made]
        return (max(abs(built.stiffness_Nm_rad / drive.stiffness_Nm_rad - 1) for built, drive in drives),
                max(abs(built.coulomb_Nm / drive.coulomb_Nm - 1) for built, drive in drives))

    told = {"actuator.stiffness_Nm_rad": 0.02, "actuator.coulomb_Nm": 0.5}
    assert 0.05 < most({})[0] < 0.10
    assert 0.20 < most({})[1] < 0.30
    assert 0.01 < most(told)[0] < 0.02
    assert 0.30 < most(told)[1] < 0.50
