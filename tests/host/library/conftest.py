"""The robot of most tests here."""

import pytest

from caramelo import Robot
from tests.host.library.places import prompt


@pytest.fixture
def robot():
    """A robot that stands on joints without mass."""
    with Robot(prompt()) as one:
        one.stand()
        yield one
