"""Grounds of a simulation in space: chosen while the joints are off, and only there."""

from contextlib import suppress
from itertools import pairwise

import pytest

from host.commands.teleop import _in_space
from host.imu.base import ImuLate
from host.robot.file import load_robot
from host.sim.servos.process import Emulator, EmulatorImu
from host.sim.stage import NAMES, ground, profiles
from host.util.errors import UserError
from tests.host.control.rig import STAND, STILL
from tests.host.teleop.web.rig import Teleop
from tests.waiting import wait_until

pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")


def test_a_script_chooses_while_the_joints_are_off(tmp_path):
    with Teleop(tmp_path, sim=("--sim", "--direct", "--in", "space")) as teleop:
        assert teleop.status()["ground"] == "flat"
        teleop.say(type="ground", ground="moon")
        teleop.say(type="ground", ground="step")
        status = teleop.wait(lambda status: status["ground"] == "step")
        assert status["obeyed"] == 1
        assert status["place"][:2] == pytest.approx((0.0, 0.0), abs=0.02)
        teleop.say(**STAND)
        teleop.wait(lambda status: teleop.say(**STILL) or status["armed"])
        teleop.say(type="ground", ground="ramp")
        teleop.wait(lambda status: teleop.say(**STILL) or status["state"] == "standing")
        assert teleop.status()["ground"] == "step"


def test_in_the_plane_there_is_nothing_to_choose(tmp_path):
    with Teleop(tmp_path) as teleop:
        teleop.say(type="ground", ground="flat")
        teleop.say(type="take")
        status = teleop.wait(lambda status: status["driver"])
        assert (status["ground"], status["place"], status["obeyed"]) == ("", None, 1)


def read(sensor):
    """Return a reading; a busy machine comes too late for some."""

    def counts():
        with suppress(ImuLate):
            return sensor.read()

    return wait_until(counts, "a reading")


def test_emulated_servos_move_a_robot_in_space():
    with Emulator("--plant", "space") as emulator:
        sensor = EmulatorImu(emulator)
        read(sensor)
        assert sensor.place[:2] == pytest.approx((0.0, 0.0), abs=0.02)
        assert 0.05 < sensor.place[2] < load_robot("caramelo").stance.rest_height_m
        sensor.choose("stairs-up")
        with pytest.raises(UserError, match="can't ground"):
            emulator.ask("ground", name="moon")
        assert len(read(sensor)) == 6


def test_emulated_servos_in_the_plane_have_no_grounds():
    with Emulator() as emulator:
        sensor = EmulatorImu(emulator)
        read(sensor)
        assert sensor.place is None
        with pytest.raises(UserError, match="only in space"):
            emulator.ask("ground", name="ramp")


def test_time_goes_on_and_the_robot_lies_at_the_start_of_the_new_ground():
    from host.sim.space.plant import SpacePlant

    plant = SpacePlant(load_robot("caramelo"))
    plant.advance_to(0.2)
    plant.drives.on[:] = [True] * 12
    plant.set_ground(ground("slope-up"))
    assert (plant.time_s, plant.drives.on) == (pytest.approx(0.2), [False] * 12)
    plant.advance_to(0.4)
    assert plant.place()[0] == pytest.approx(0.0, abs=0.02)
    assert plant.world.time_s == pytest.approx(0.2)


def test_profiles_rise_along_the_way():
    assert tuple(profiles()) == NAMES
    for name, line in profiles().items():
        assert all(later[0] >= earlier[0] for earlier, later in pairwise(line)), name
    assert {z for _, z in profiles()["flat"]} == {0.0}
    assert max(z for _, z in profiles()["stairs-up"]) > 0.1


def test_space_is_the_default_of_a_simulation_and_of_nothing_else():
    assert _in_space(None, True)
    assert not _in_space("plane", True)
    assert not _in_space(None, False)
    for where, sim, words in (("moon", True, "allowed: space, plane"), ("space", False, "only with --sim")):
        with pytest.raises(UserError, match=words):
            _in_space(where, sim)
