"""The search and its store: it finds what a plain score hides, the same however often it was ended."""

import json

import pytest

pytest.importorskip("cma", reason="cma is not installed (extra lab)")

from host.lab.tune.search import search
from host.lab.tune.store import Store
from host.lab.tune.values import Searched
from host.util.errors import UserError

SEARCHED = [Searched("a.x", 0.5, 0.0, 1.0), Searched("a.y", 30.0, 10.0, 50.0), Searched("a.z", 0.0, -0.1, 0.1)]
TOP = {"a.x": 0.8, "a.y": 18.0, "a.z": 0.05}
HEAD = {"goal": "test"}


def hill(values):
    """Return 1 at TOP, less by the square of the way to it in shares of the ranges."""
    return 1 - sum(((values[each.key] - TOP[each.key]) / (each.high - each.low)) ** 2 for each in SEARCHED)


def evaluate(candidates):
    return [hill(values) for values in candidates]


def searched(path, trials, by=evaluate):
    store = Store(path, HEAD)
    search(SEARCHED, by, trials, store)
    return store


def test_it_comes_near_the_top_from_the_files_own_values(tmp_path):
    store = searched(tmp_path / "trials.jsonl", 120)
    assert store.trials[0] == ({"a.x": 0.5, "a.y": 30.0, "a.z": 0.0}, hill({"a.x": 0.5, "a.y": 30.0, "a.z": 0.0}))
    assert len(store.trials) == 120
    assert store.trials[0][1] < 0.8 < 0.999 < store.best[1]
    for values, _ in store.trials:
        assert all(each.low <= values[each.key] <= each.high for each in SEARCHED)


@pytest.mark.parametrize("ended_at", [1, 2, 9, 30, 59])
def test_one_that_was_ended_goes_on_as_if_it_had_not_been(tmp_path, ended_at):
    whole = searched(tmp_path / "whole.jsonl", 60)
    left = (tmp_path / "whole.jsonl").read_text().splitlines()[: 1 + ended_at]
    power_cut = '{"values": {"a.x": 0.'
    (tmp_path / "part.jsonl").write_text("\n".join([*left, power_cut]))
    tried = []
    part = searched(tmp_path / "part.jsonl", 60, lambda values: tried.extend(values) or evaluate(values))
    assert part.trials == whole.trials
    assert len(tried) == 60 - ended_at
    assert (tmp_path / "part.jsonl").read_text() == (tmp_path / "whole.jsonl").read_text()


def test_ctrl_c_leaves_the_trials_that_are_done(tmp_path):
    def stops(candidates):
        if len(Store(tmp_path / "trials.jsonl", HEAD).trials) > 10:
            raise KeyboardInterrupt
        return evaluate(candidates)

    with pytest.raises(KeyboardInterrupt):
        searched(tmp_path / "trials.jsonl", 60, stops)
    kept = Store(tmp_path / "trials.jsonl", HEAD)
    assert len(kept.trials) > 10
    assert kept.trials == searched(tmp_path / "other.jsonl", 60).trials[: len(kept.trials)]


def test_trials_of_another_search_are_refused(tmp_path):
    path = tmp_path / "trials.jsonl"
    searched(path, 12)
    with pytest.raises(UserError, match=r"trials belong to another search \(goal\): remove it"):
        Store(path, {"goal": "another"})
    lines = path.read_text().splitlines()
    lines[3] = json.dumps({"values": TOP, "score": 1.0})
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(UserError, match=r"trials from 2 on differ from those that this numpy and cma would make"):
        searched(path, 12)
    path.write_text("no trials\n")
    with pytest.raises(UserError, match="not a file of trials"):
        Store(path, HEAD)
