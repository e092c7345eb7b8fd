"""Tests of the simulator in space; without MuJoCo they are skipped."""

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
