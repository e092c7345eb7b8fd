"""A copy of a robot file gets what was measured: values, source, date and spread; all else stays as it was."""

from datetime import date

import pytest

from host.identify.filing import Measure, copy_with
from host.robot.file import FOLDER, RobotFileError, load_robot
from tests.host.robot.test_robot_file import unit_complaints

WHEN = date(2026, 3, 4)
FOUND = {
    "actuator.coulomb_Nm": Measure(0.0712, 0.04), "actuator.friction.load_motor": Measure(0.155, 0.02),
    "actuator.supply_ohm": Measure(0.21), "bus.delay_s": Measure(0.0123), "stall_Nm": Measure(2.25, 0.03),
    "no_load_rad_s": Measure(6.0, 0.01), "actuator.backlash_deg": Measure(0.8, 0.1),
}  # fmt: skip


def copied(tmp_path, source, found=FOUND):
    target = tmp_path / "out" / "copy.toml"
    copy_with(source, target, load_robot(str(source)).actuator, found, WHEN)
    return target


def test_what_was_measured_is_in_the_copy_and_nothing_else_has_changed(tmp_path):
    source = FOLDER / "caramelo.toml"
    target = copied(tmp_path, source)
    robot, was = load_robot(str(target)), load_robot(str(source))
    servo = robot.actuator
    assert (servo.coulomb_Nm, servo.friction.load_motor, servo.supply_ohm) == (0.0712, 0.155, 0.21)
    assert (servo.nominal.stall_Nm, robot.bus.delay_s, servo.backlash_deg) == (2.25, 0.0123, 0.8)
    assert servo.nominal.no_load_rad_s == pytest.approx(6.0, rel=1e-3)
    # The other supply points keep their ratio to the nominal one.
    assert servo.supply[0].stall_Nm == pytest.approx(was.actuator.supply[0].stall_Nm * 2.25 / 2.5, rel=1e-3)
    old, new = source.read_text().splitlines(), target.read_text().splitlines()
    assert len(old) == len(new)
    changed = [line for before, line in zip(old, new, strict=True) if before != line]
    assert len(changed) == 5 + 2 * len(servo.supply)
    assert all("2026-03-04" in line and ": measured)" in line for line in changed)
    assert any("+-4 % between joints" in line for line in changed)
    assert unit_complaints(target.read_text()) == []


def test_keys_that_the_file_lacks_are_added(tmp_path):
    kept = []
    lacks = ("stribeck", "viscous", "load_", "[actuator.friction]", "supply_ohm", "backlash", "delay_s")
    for line in (FOLDER / "caramelo.toml").read_text().splitlines():
        if not line.startswith(lacks):
            kept.append(line)
    source = tmp_path / "bare.toml"
    source.write_text("\n".join(kept) + "\n")
    target = copied(tmp_path, source)
    robot = load_robot(str(target))
    assert (robot.actuator.friction.load_motor, robot.actuator.supply_ohm, robot.bus.delay_s) == (0.155, 0.21, 0.0123)
    assert unit_complaints(target.read_text()) == []


def test_numbers_that_no_robot_may_have_leave_no_file(tmp_path):
    with pytest.raises(RobotFileError, match="load_motor"):
        copied(tmp_path, FOLDER / "caramelo.toml", {"actuator.friction.load_motor": Measure(3.0, 0.1)})
    assert not list((tmp_path / "out").iterdir())
