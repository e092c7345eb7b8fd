"""The real firmware of a gait board on a pretend one: self-test, planner and all, as the build makes it."""

import json

from host import cli
from tests.flash.pretend import PretendBoard


def test_the_gait_firmware_starts_and_another_robot_is_one_small_file(tmp_path, capsys):
    with PretendBoard(tmp_path / "board", size=2 << 20) as board:
        command = ["flash", "--port", board.port, "--role", "gait", "--json"]
        assert cli.main(command) == 0
        (first,) = json.loads(capsys.readouterr().out)["boards"]
        assert (first["self_test"], first["slot"]) == ("passed", "a")
        assert cli.main([*command, "--robot", "parallel", "--dry-run"]) == 0
        (second,) = json.loads(capsys.readouterr().out)["boards"]
        assert second["uploaded"] == ["b/firmware/robot_params.mpy"]
