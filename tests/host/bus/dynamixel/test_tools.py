"""Looking for servos: together and one by one, each finds what the other has missed."""

import pytest

from host.bus.dynamixel.tools import find

from .rig import Rig

ALL = list(range(1, 13))


@pytest.fixture
def link():
    return Rig().bus.link


def ids(link):
    return [found.id for found in find(link)]


def test_all_are_found_with_each_protocol():
    for protocol in (1.0, 2.0):
        found = find(Rig(protocol).bus.link)
        assert [(one.id, one.model, one.protocol) for one in found] == [(number, 30, protocol) for number in ALL]


def test_who_is_not_heard_among_the_others_is_asked_alone(link, monkeypatch):
    heard = link.ping_all()
    monkeypatch.setattr(link, "ping_all", lambda: {servo: model for servo, model in heard.items() if servo > 3})
    assert ids(link) == ALL


def test_who_does_not_answer_alone_is_heard_among_the_others(link, monkeypatch):
    monkeypatch.setattr(link, "ping", lambda *arguments: None)
    assert ids(link) == ALL


def test_where_some_are_missing_all_are_asked_once_more(link, monkeypatch):
    heard = link.ping_all()
    answers = [{7: heard[7]}, heard]
    monkeypatch.setattr(link, "ping", lambda *arguments: None)
    monkeypatch.setattr(link, "ping_all", lambda: answers.pop(0))
    assert ids(link) == ALL


def test_one_who_is_missed_by_protocol_1_is_asked_again_with_more_patience(monkeypatch):
    link = Rig(1.0).bus.link
    ping = link.ping
    slow = lambda servo, tries, ms: None if servo == 5 and ms < 20.0 else ping(servo, tries, ms)  # noqa: E731
    monkeypatch.setattr(link, "ping", slow)
    assert ids(link) == ALL
