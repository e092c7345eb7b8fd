"""What tests of any folder use: the command, run in this process."""

import os

import pytest
from hypothesis import HealthCheck, settings

from host import cli
from host.boards.core import SWITCH, use_core

os.environ.setdefault(SWITCH, "source")  # the sources are tested, unless CARAMELO_CORE names a folder of compiled cores
use_core()
# How long an example takes, to run or to be drawn, says how busy the machine is.
settings.register_profile("caramelo", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("caramelo")


@pytest.fixture
def run(capsys):
    """Run the command in this process; return exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main(arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return call
