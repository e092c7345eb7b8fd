"""What tests of any folder use: the command, run in this process."""

import pytest

from host import cli


@pytest.fixture
def run(capsys):
    """Run the command in this process; return exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main(arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return call
