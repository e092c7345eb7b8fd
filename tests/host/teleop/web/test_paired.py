"""Pairings that outlast a restart: kept as hashes, revoked one by one or all, and what a damaged file does."""

import pytest

from host.teleop.web.access import Pairing
from host.teleop.web.paired import MOST_TOKENS, NAME, Paired, paired_path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "state" / NAME


def test_a_browser_is_known_after_a_restart(path):
    first = Pairing("123456", (), lambda: 0.0, Paired(path))
    token = first.pair("123456", "10.0.0.2")
    again = Pairing("654321", (), lambda: 0.0, Paired(path))
    assert again.allows(token, "10.0.0.9")
    assert not again.allows("another", "10.0.0.9")
    assert token not in path.read_text()
    assert path.stat().st_mode & 0o777 == 0o600


def test_one_is_revoked_and_the_others_stay(path):
    paired = Paired(path)
    paired.add("a")
    paired.add("b")
    paired.forget("a")
    assert [Paired(path).allows(token) for token in "ab"] == [False, True]


def test_what_another_program_revokes_counts_at_once(path):
    ours, other = Paired(path), Paired(path)
    ours.add("a")
    assert ours.allows("a")
    other.forget_all()
    assert not ours.allows("a")
    assert not path.exists()


def test_the_oldest_goes_when_there_are_too_many(path):
    paired = Paired(path)
    for number in range(MOST_TOKENS + 1):
        paired.add(str(number))
    assert len(Paired(path).browsers()) == MOST_TOKENS
    assert not paired.allows("0")
    assert paired.allows("1")


@pytest.mark.parametrize("text", ["", "[]", '{"browsers": [{"hash": 1}]}', '{"browsers": 3}', "\x00"])
def test_of_a_damaged_file_nobody_is_paired_and_that_is_told(path, text):
    path.parent.mkdir()
    path.write_text(text)
    paired = Paired(path)
    assert not paired.allows("a")
    assert "so no browser is paired" in paired.trouble
    paired.add("a")
    assert Paired(path).allows("a")


def test_where_nothing_can_be_written_it_holds_for_this_run(tmp_path):
    (tmp_path / "file").write_text("")
    paired = Paired(tmp_path / "file" / NAME)
    paired.add("a")
    assert paired.allows("a")
    assert paired.trouble.startswith("pairings are not kept over a restart: ")


def test_the_services_file_is_in_its_state_directory(monkeypatch, tmp_path):
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/caramelo")
    assert str(paired_path()) == "/var/lib/caramelo/paired.json"
    monkeypatch.delenv("STATE_DIRECTORY")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert paired_path() == tmp_path / "caramelo" / NAME


def test_the_command_lists_and_revokes(run, run_json, path):
    Paired(path).add("a")
    code, out, err = run("pairings", "--folder", str(path.parent))
    assert (code, err) == (0, "")
    assert out.startswith("1 browser is paired (")
    assert "since 20" in out
    code, told, _ = run_json("pairings", "--folder", str(path.parent), "--forget")
    assert (code, told["forgotten"], len(told["paired_since"])) == (0, True, 1)
    assert run("pairings", "--folder", str(path.parent))[1].startswith("0 browsers are paired (")
