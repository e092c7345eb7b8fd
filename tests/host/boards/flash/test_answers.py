"""Boards that answer anything: flashing ends well or says in one line what is wrong, and never in a traceback."""

import contextlib
import json
import random
from copy import deepcopy

import pytest

from host.boards.flash import flash as flashing
from host.boards.flash import inspect, link
from host.boards.flash.flash import Outcome, Wish, flash
from host.boards.flash.link import BoardLink, BoardScriptError
from host.util.errors import UserError

from .trees import make

WRONG = [None, True, False, 0, 1, -1, 2**31, 2**63, 10**40, 1.5, float("nan"), "", "x", "\x1b[2J\x9b", "a" * 5000,
         [], {}, [1], ["a", "b"], {"a": 1}, [[]], [None] * 3, {"../x": ["0" * 64, 1]}, {"a/../../b": ["0" * 64, 1]},
         "c", "\ud800",
         {"a/x": ["0" * 64, 2**70]}, {"a/x": [1, 2]}, {"/etc/passwd": ["0" * 64, 1]}, ["../.."],
         "b"]  # fmt: skip
LINES = ["", "[", "[" * 50_000, "null", "3", "[]", '"x"', "{", "{}", '{"a":' * 20_000, "NaN", "\x00", "\x1b[2J", "{]",
         "9" * 5000]  # fmt: skip


SUPPLY, BUILD = 0, make("1").about.build


def report():
    return {"slot": "a", "stage": "running", "self_test": "", "error": "", "confirmed": True, "board": "CARAMELO_GAIT",
            "build": BUILD, "role": "gait", "version": "1", "protocol": None}  # fmt: skip


def survey():
    """Return what a board with a firmware in slot a answers."""
    held = {"build": BUILD, "version": "1", "sha256": make("1").header(0).sha256.hex()}
    return {"version": [1, 29, 0], "report": report(), "slots": [held, None], "wished": [0, 255], "supply_mV": SUPPLY}


def confirm(link):
    """Do what follows the writing of slot a."""
    wish = Wish(make("1"))
    flashing._confirm(link, wish, 0, Outcome("board", BUILD, "a", True, False, 0))


class Board(BoardLink):
    """A link to a board that is none; ``spoil`` changes what it answers."""

    def __init__(self, port, spoil):
        super().__init__(port)
        self.spoil = spoil

    def interrupt(self):
        pass

    def reset(self):
        pass

    def wait_until_back(self):
        pass

    def listen(self, seconds, take=lambda data: False):
        pass

    def run(self, script, timeout_s=0.0):
        answers = {"u.wished()": survey, "start.report()": report, "u.is_whole": lambda: True,
                   "u.begin": lambda: [8, 9], "start.log()": lambda: "slot a: broken\n"}
        for mark, answer in answers.items():
            if mark in script and "def answer" not in script:
                return "noise\r\n@@" + self.spoil(answer()) + "\r\n"
        return ""


def places(value, path=()):
    """Yield the paths to everything in an answer."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in inner:
        yield from places(each, (*path, key))


def mutated(answer, rng):
    """Return an answer's line with something else in one or two places."""
    if rng.random() < 0.1:
        return rng.choice(LINES)
    for _ in range(rng.randrange(1, 3)):
        paths = [path for path in places(answer) if path]
        if not paths:
            answer = deepcopy(rng.choice(WRONG))
            break
        *above, last = rng.choice(paths)
        inside = answer
        for key in above:
            inside = inside[key]
        if rng.random() < 0.25:
            del inside[last]
        else:
            inside[last] = deepcopy(rng.choice(WRONG))
    line = json.dumps(answer)
    if rng.random() < 0.2:
        at = rng.randrange(len(line))
        line = line[:at] + rng.choice(["", "\x00", '"', "]", "{", "é"]) + line[at + rng.randrange(3) :]
    return line


@pytest.fixture
def board(monkeypatch):
    """Let flashing meet a board that spoils its answers."""

    def use(spoil):
        monkeypatch.setattr(link, "BoardLink", lambda port: Board(port, spoil))

    return use


@pytest.mark.parametrize("what", ["flash", "dry", "confirm", "info", "log"])
def test_mutated_answers_never_end_in_a_traceback(board, what):
    """500 boards each; most are refused, some answer by chance what is allowed. None keeps what is written to it."""
    rng = random.Random(what)
    board(lambda answer: mutated(answer, rng) if rng.random() < 0.7 else json.dumps(answer))
    do = {
        "flash": lambda: flash("board", Wish(make("1"))),
        "dry": lambda: flash("board", Wish(make("2"), dry_run=True)),
        "confirm": lambda: confirm(link.BoardLink("board")),
        "info": lambda: inspect.describe("board"),
        "log": lambda: inspect.read_log("board"),
    }[what]
    refused = 0
    for _ in range(500):
        with contextlib.suppress(UserError):
            do()
            continue
        refused += 1
    assert 30 < refused < (501 if what == "flash" else 500)


def test_what_the_board_should_answer_is_taken(board):
    board(json.dumps)
    assert flash("board", Wish(make("2"), dry_run=True)).slot == "b"
    assert inspect.describe("board")["version"] == "1"
    assert inspect.read_log("board") == ["slot a: broken"]


def test_the_place_and_what_is_wrong_are_told(board):
    board(lambda answer: json.dumps(answer | {"supply_mV": "much"}))
    with pytest.raises(UserError, match=r"board: the board's answer can't be read: supply_mV: .*integer: reset it"):
        inspect.describe("board")


@pytest.mark.parametrize(
    "words", ["", "\n", "OSError: ²", "OSError: [Errno 28] x", "OSError", "Traceback\n  File\nValueError: \x1b[2J"]
)
def test_any_complaint_of_a_board_is_a_sentence(words):
    class Serial:
        def exec_raw(self, script, timeout):
            return b"", words.encode() or b" "

    one = BoardLink("board")
    one._link = Serial()
    with pytest.raises(BoardScriptError, match=r"^board: the board says [^\n]+$"):
        one.run("x")
