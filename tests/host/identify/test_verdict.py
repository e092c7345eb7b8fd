"""What is said of a joint beside its brothers."""

from dataclasses import replace

import pytest

from host.identify import sweeping
from host.identify.carried import in_the_air
from host.identify.fit import Fitted
from host.identify.plan import plan
from host.identify.verdict import (
    LOOSE,
    REVERSED,
    SOUND,
    STICKING,
    STICKS,
    STIFF,
    judge,
    sticking,
    weight_is,
    with_middle,
)
from host.sim.servos.honest import reference_shaft_rad

from .robots import ROBOT, SERVO, stand, truth

ALIKE = {**truth(stand(3), 0), "act_s": 0.01}


def fits(**changed):
    """Return four joints' fits; RL thigh is changed."""
    found = {joint: Fitted(dict(ALIKE)) for joint in (1, 4, 7, 10)}
    found[10].values.update({name: ALIKE[name] * times for name, times in changed.items()})
    return found


def test_joints_that_are_alike_are_sound():
    assert judge(10, fits(), (1.1, 0.0)).kind == SOUND
    assert judge(10, fits(stall_Nm=1.15), (1.1, 0.0)).sentence == "RL thigh: like the other joints"


def test_more_friction_than_its_brothers():
    verdict = judge(10, fits(coulomb_Nm=2.0, stribeck_Nm=2.0), (1.1, 0.0))
    assert (verdict.kind, verdict.sentence) == (STIFF, "RL thigh: 100 % more friction than the other joints")
    assert judge(4, fits(coulomb_Nm=2.0, stribeck_Nm=2.0), (1.1, 0.0)).kind == SOUND


def test_less_torque_and_more_play():
    sentence = judge(10, fits(stall_Nm=0.7, backlash_rad=2.0), (1.1, 0.0)).sentence
    assert sentence == "RL thigh: 30 % less torque, 100 % more play than the other joints"


def test_sticking_says_where():
    verdict = judge(10, fits(), (3.0, 0.5))
    assert verdict.kind == STICKING
    assert "29 deg" in verdict.sentence
    assert "3.0 times" in verdict.sentence


@pytest.fixture
def few_runs(monkeypatch):
    runs = ("run +0.11", "run -0.11", "run +0.18", "run -0.18", "run +0.24", "run -0.24")
    monkeypatch.setattr(sweeping, "plan", lambda *args: [sweep for sweep in plan(*args) if sweep.name in runs])


@pytest.mark.parametrize(("fault", "kind"), [("", SOUND), ("loose horn", LOOSE), ("reversed", REVERSED)])
@pytest.mark.parametrize("joint", [0, 2])
def test_runs_show_which_weight_a_joint_feels(few_runs, joint, fault, kind):
    made = stand(216, fault, joint)
    traces = sweeping.sweep_joint(made.rig, joint)
    assert weight_is(SERVO, in_the_air(ROBOT, joint), traces, reference_shaft_rad(ROBOT, joint)) == kind


@pytest.mark.parametrize("fault", ["sticking", ""])
def test_a_joint_that_sticks_at_one_place_is_found_by_its_runs(few_runs, fault):
    made = stand(8, fault, 1)
    traces = sweeping.sweep_joint(made.rig, 1)
    values = {**truth(made, 1), "act_s": made.plant.made.figures[1].delay_s}
    times, where = sticking(SERVO, in_the_air(ROBOT, 1), traces, values)
    if fault:
        assert times > STICKS
        assert where == pytest.approx(sweeping.rest_shafts_rad(ROBOT)[1] + 0.15, abs=0.1)
    else:
        assert times < 1.1


def test_a_joint_whose_places_too_few_runs_saw_is_not_called_sticking(few_runs):
    made = stand(8, "sticking", 1)
    traces = sweeping.sweep_joint(made.rig, 1)
    assert sticking(SERVO, in_the_air(ROBOT, 1), traces[:1], {**truth(made, 1), "act_s": 0.01}) == (1.0, 0.0)


def test_the_middle_of_the_joints_and_how_far_they_spread():
    middle = with_middle({j: replace(fit, answer_s=0.002) for j, fit in fits(stall_Nm=3.0).items()})
    assert middle.values["stall_Nm"] == pytest.approx(ALIKE["stall_Nm"])
    assert middle.spread["stall_Nm"] > 0.5
    assert middle.delay_s == pytest.approx(0.012)
