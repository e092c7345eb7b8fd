"""No intermediate of the core leaves -2^30 .. 2^30-1, shown on an integer that refuses to."""

import shutil

import pytest

from host.boards.runtimes import CPython
from host.boards.runtimes.base import RuntimeFailure
from host.lab.parity import checked
from host.lab.parity.checked import Checked, Overflow

from .plant import plant


def test_no_intermediate_leaves_the_range(largest):
    assert {name: error for name, (_, error) in largest.items() if error} == {}


PRODUCT = "return (a * b_q15 + 0x4000) >> 15"
PLANTED = [
    ("2^30", "num/fixed", PRODUCT, "return (a * b_q15 << 1) + 0x8000 >> 16", "outside -2^30 .. 2^30-1"),
    ("one value only", "num/fixed", PRODUCT, "return (a * b_q15 + ((a == 23457) << 31) + 0x4000) >> 15", "outside"),
    ("a float", "num/fixed", PRODUCT, "return int(a * b_q15 * 0.000030517578125)", "a float"),
    ("true division", "num/fixed", PRODUCT, "return a * b_q15 / 32768", "a float"),
    ("a shift by 32", "num/fixed", PRODUCT, "return (a * b_q15 + 0x4000) >> 32", "shifts by 0 .. 31"),
    ("a list", "num/fixed", PRODUCT, "return [a * b_q15]", "a list"),
    ("a tuple", "num/fixed", PRODUCT, "return a, b_q15", "a tuple"),
    ("an index before an array", "num/fixed", "at = angle_brad >> 5 & 2046", "at = -(angle_brad >> 5 & 2046)",
     "before the array"),
    ("a divisor of 0", "body/reach", "if denominator < 1:\n        return 0\n    if", "if", "ZeroDivisionError"),
]


@pytest.mark.parametrize("row", PLANTED, ids=[row[0] for row in PLANTED])
def test_a_planted_mistake_is_found(sources, tmp_path, row):
    _, module, right, wrong, words = row
    copy = plant(sources, tmp_path, f"shared/{module}.py", right, wrong)
    runtime = CPython()
    tree = runtime.prepare(copy, tmp_path)
    shutil.copy(checked.__file__, tree)
    try:
        rows = runtime.ask(tree, f"import checked\nchecked.answer({module.rpartition('/')[2]!r}, 40)\n")["rows"]
        found = " ".join(row["error"] for row in rows if row["error"])
    except RuntimeFailure as failure:  # a float literal is refused when the module is loaded
        found = str(failure)
    assert words in found


def test_checked_integers_stay_checked():
    three = Checked(3)
    for value in (three + 4, 4 - three, -three, three // 2, 7 % three, three << 3, ~three, abs(three)):
        assert type(value) is Checked
    assert int(Checked(7) >> 1) == 3
    assert Checked(3) > 2


@pytest.mark.parametrize(
    "overflow",
    [
        lambda: Checked((1 << 30) - 1) + 1,
        lambda: Checked(-(1 << 30)) - 1,
        lambda: -Checked(-(1 << 30)),
        lambda: Checked(1 << 15) * (1 << 15),
        lambda: Checked(1) << 30,
        lambda: Checked(1) / 1,
        lambda: 1 / Checked(1),
        lambda: Checked(1) + 0.5,
    ],
)
def test_what_is_not_a_small_integer_is_refused(overflow):
    with pytest.raises(Overflow):
        overflow()
