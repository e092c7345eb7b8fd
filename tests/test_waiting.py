"""Tests wait for events, through tests/waiting.py: no sleep, no clock in a loop, no wait without a bound of its own."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from .waiting import stays, wait_until

TESTS = Path(__file__).resolve().parent
SLEEPS = {"sleep", "sleep_ms", "wait_for_timeout"}
CLOCKS = {"monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns"}
PAGES = {"new_page", "new_context"}
WAITS = {"wait", "join", "communicate"}  # of a process, a thread or an event; "".join and rig.wait have arguments


def called(node: ast.AST) -> str:
    """Return the last part of the name that a node calls, "" if it is no call."""
    if not isinstance(node, ast.Call):
        return ""
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def impatient(tree: ast.AST) -> Iterator[ast.Call]:
    """Yield what opens a browser's page or context and leaves it the library's bound."""
    nodes = list(ast.walk(tree))
    patient = {id(each) for node in nodes if called(node) == "patient" for each in node.args}
    for node in nodes:
        if called(node) in PAGES and id(node) not in patient and ast.unparse(node.func.value) == "browser":
            yield node


def offences(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and sentence of everything that lets time pass, or waits for ever."""
    for node in ast.walk(tree):
        if called(node) in SLEEPS:
            yield node.lineno, "sleeps: wait for the event instead (wait_until)"
        elif called(node) in WAITS and not node.args and not node.keywords and isinstance(node.func, ast.Attribute):
            yield node.lineno, f"{called(node)}() without a bound: give it PATIENCE_S"
        elif isinstance(node, ast.While) and any(called(each) in CLOCKS for each in ast.walk(node)):
            yield node.lineno, "a loop on a clock: wait_until does this"
    yield from ((node.lineno, "gives up after 30 s: patient() does not") for node in impatient(tree))


def test_no_test_waits_for_time_or_for_ever():
    found = [
        f"{path.relative_to(TESTS)}:{line}: {told}"
        for path in sorted(TESTS.rglob("*.py"))
        if path.name != "waiting.py"
        for line, told in offences(ast.parse(path.read_text()))
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        "time.sleep(1)",
        "async def f():\n    await asyncio.sleep(0.1)",
        "from time import sleep\nsleep(2)",
        "page.wait_for_timeout(500)",
        "process.wait()",
        "thread.join()",
        "out, err = process.communicate()",
        "while time.monotonic() < end:\n    pass",
        "while True:\n    if monotonic() > end:\n        break",
        "page = browser.new_page()",
        "page = browser.new_context(has_touch=True).new_page()",
    ],
)
def test_what_waits_for_time_or_for_ever_is_found(text):
    assert len(list(offences(ast.parse(text)))) == 1


@pytest.mark.parametrize(
    "text",
    ["', '.join(words)", "process.wait(5)", "event.wait(timeout=5)", "began = time.monotonic()",
     "patient(browser.new_context()).new_page()"],
)
def test_what_has_a_bound_is_let_through(text):
    assert list(offences(ast.parse(text))) == []


def test_waiting_returns_what_happened_and_says_what_did_not():
    answers = iter(["", [], "came"])
    assert wait_until(lambda: next(answers), "it comes") == "came"
    with pytest.raises(AssertionError, match=r"not within 0.01 s: \[3\]"):
        wait_until(lambda: False, lambda: [3], 0.01)
    assert stays(lambda: True, 0.01)
    assert not stays(lambda: False, 60.0)
