"""Robots on a simulated bus in the states in which most tests of this folder begin."""

import pytest

from .robot import Walker


@pytest.fixture
def seated():
    """A robot that nobody has armed yet."""
    with Walker() as walker:
        yield walker


@pytest.fixture
def standing(seated):
    """The same once it is armed and stands."""
    seated.arm()
    seated.stand_up()
    return seated
