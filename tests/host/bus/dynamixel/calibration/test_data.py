"""Calibration files: what is refused and why, whole files with a backup, and counts to angles and back."""

import dataclasses
from math import degrees, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.bus.dynamixel.calibration.data import (
    Calibration,
    CalibrationError,
    JointCalibration,
    check,
    counts_per_rad,
    default_path,
    limits_rad,
    load_calibration,
    nominal,
    save_calibration,
    to_text,
)
from host.robot.file import load_robot
from host.robot.poses import rest_pose_rad
from host.util.errors import UserError

CARAMELO = load_robot("caramelo")
PLAN = nominal(CARAMELO)


def changed(joint, **values):
    """Return the plan with some values of a joint changed."""
    joints = list(PLAN.joints)
    joints[joint] = dataclasses.replace(joints[joint], **values)
    return Calibration("caramelo", tuple(joints))


def test_counts_of_known_angles():
    """A quarter turn of a thigh is 1024 counts; of a calf 1024 / 1.12283 = 912, as its rod turns it faster."""
    per_rad = counts_per_rad(CARAMELO)
    thigh = JointCalibration(2, 1, 1000, 0, 4095)
    assert thigh.counts(pi / 2, per_rad[1]) == 2024
    assert dataclasses.replace(thigh, sign=-1).counts(pi / 2, per_rad[1]) == -24
    assert thigh.counts(-pi / 2, per_rad[2]) == 1000 - 912
    assert thigh.limited_counts(pi, per_rad[1]) == 3048
    assert dataclasses.replace(thigh, max=2500).limited_counts(pi, per_rad[1]) == 2500


@given(st.integers(0, 11), st.integers(0, 4095), st.sampled_from([-1, 1]), st.integers(-4095, 8190))
def test_angles_and_back(joint, counts, sign, zero):
    per_rad = counts_per_rad(CARAMELO)[joint]
    mount = JointCalibration(1, sign, zero, 0, 4095)
    assert mount.counts(mount.angle_rad(counts, per_rad), per_rad) == counts


def test_the_plan_is_right_and_reaches_the_limits():
    assert check(PLAN, CARAMELO, "plan") is PLAN
    rows = zip(PLAN.joints, limits_rad(CARAMELO), counts_per_rad(CARAMELO), strict=True)
    for mount, (low, high), per_rad in rows:
        ends = sorted((mount.angle_rad(mount.min, per_rad), mount.angle_rad(mount.max, per_rad)))
        assert degrees(abs(ends[0] - low)) < 0.1
        assert degrees(abs(ends[1] - high)) < 0.1


REST = PLAN.joints[1].counts(rest_pose_rad(CARAMELO)[1], counts_per_rad(CARAMELO)[1])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"id": 3}, "FR thigh.id: value 3: allowed: an id for one joint only; FR thigh and FR calf share it"),
        ({"id": 253}, "FR thigh.id: value 253: allowed: 0 .. 252"),
        ({"id": -1}, "allowed: 0 .. 252"),
        ({"sign": 0}, "FR thigh.sign: value 0: allowed: 1 (more counts, larger angle) or -1"),
        ({"sign": 2}, "FR thigh.sign"),
        ({"zero": 9000}, "FR thigh.zero: value 9000"),
        ({"min": 3000, "max": 1000}, "allowed: 0 <= min < max <= 4095 counts"),
        ({"min": -5}, "allowed: 0 <= min"),
        ({"max": 4096}, "max <= 4095"),
        ({"min": REST + 1}, "limits that contain the rest stance"),
        ({"max": REST - 1}, "the zero or the sign is wrong"),
        ({"sign": 1}, "limits that contain the rest stance"),
    ],
)
def test_nonsense_is_refused(values, words):
    with pytest.raises(CalibrationError) as wrong:
        check(changed(1, **values), CARAMELO, "some.toml")
    assert str(wrong.value).startswith("some.toml: ")
    assert words in str(wrong.value)


def test_the_edge_of_the_limits_is_allowed():
    assert check(changed(1, min=REST), CARAMELO, "")
    assert check(changed(1, max=REST), CARAMELO, "")


def test_another_robots_file_is_refused():
    with pytest.raises(CalibrationError, match='robot: value "spot"'):
        check(Calibration("spot", PLAN.joints), CARAMELO, "x")
    with pytest.raises(UserError, match="parallel has no servos"):
        check(Calibration("parallel", PLAN.joints), load_robot("parallel"), "x")


def test_files_come_back_as_they_were(tmp_path):
    path = tmp_path / "deep" / "caramelo.toml"
    assert save_calibration(path, PLAN) is None
    assert load_calibration(path, CARAMELO) == PLAN
    assert save_calibration(path, PLAN) is None
    kept = save_calibration(path, changed(1, zero=PLAN.joints[1].zero + 5))
    assert kept == tmp_path / "deep" / "caramelo.toml.backup"
    assert load_calibration(kept, CARAMELO) == PLAN
    assert load_calibration(path, CARAMELO) != PLAN
    assert sorted(file.name for file in path.parent.iterdir()) == ["caramelo.toml", "caramelo.toml.backup"]


@pytest.mark.parametrize(
    ("was", "now", "words"),
    [
        ("id = 2, ", "", "FR.thigh.id: missing"),
        ("id = 2,", "id = 2, size = 3,", "FR.thigh.size: unknown"),
        ("id = 2,", 'id = "2",', 'FR.thigh.id: value "2": allowed: a whole number'),
        ("id = 2,", "id = 2.0,", "FR.thigh.id: value 2.0"),
        ("id = 2,", "id = true,", "FR.thigh.id: value true"),
        ("[FL]", "[LF]", "LF: unknown key"),
        ("[FL]\nhip", "[FL]\nhop", "FL.hip: missing"),
        ('robot = "caramelo"', "", "robot: value"),
        ('robot = "caramelo"', 'robot = "caramelo', "not TOML"),
    ],
)
def test_files_that_are_wrong_are_refused(tmp_path, was, now, words):
    path = tmp_path / "c.toml"
    text = to_text(PLAN)
    assert was in text
    path.write_text(text.replace(was, now))
    with pytest.raises(CalibrationError) as wrong:
        load_calibration(path, CARAMELO)
    assert words in str(wrong.value)
    assert str(path) in str(wrong.value)


def test_no_file_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    path = default_path(CARAMELO)
    assert path == tmp_path / "caramelo" / "caramelo.calibration.toml"
    with pytest.raises(CalibrationError, match="no calibration yet; run: caramelo calibrate"):
        load_calibration(path, CARAMELO)
