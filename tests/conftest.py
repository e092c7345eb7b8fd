"""What tests of any folder use: the command, run in this process, and a port at which nobody answers."""

import json
import os
import pty

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants

from host import cli
from host.boards.core import SWITCH, use_core

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command has it (host/__main__.py)
os.environ.setdefault(SWITCH, "source")  # the sources are tested, unless CARAMELO_CORE names a folder of compiled cores
use_core()
# How long an example takes, to run or to be drawn, says how busy the machine is. A run draws what any other draws;
# `--hypothesis-profile=explore` draws other examples each time. Hypothesis would also draw constants of what happens to
# be imported, which depends on the tests run before.
settings.register_profile(
    "caramelo", deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("explore", settings.get_profile("caramelo"), derandomize=False)
settings.load_profile("caramelo")
providers._get_local_constants = Constants


@pytest.fixture
def silent_port():
    """The path of a serial port at which nobody answers."""
    ours, theirs = pty.openpty()
    yield os.ttyname(theirs)
    os.close(ours)
    os.close(theirs)


@pytest.fixture
def run(capsys):
    """Run the command in this process; return exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main(arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def run_json(run):
    """Run the command with --json; return exit code, the object that is the one line on stdout, and stderr."""

    def call(*arguments):
        code, out, err = run(*arguments, "--json")
        assert out.count("\n") == 1, (code, out, err)
        return code, json.loads(out), err

    return call


@pytest.fixture
def refused(run):
    """Run the command, which ends with this exit code and prints nothing but one line on stderr; return that line."""

    def call(*arguments, code=2):
        got, out, err = run(*arguments)
        assert (got, out, err.count("\n")) == (code, "", 1), err
        return err

    return call
