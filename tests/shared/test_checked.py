"""The core on checked integers, driven with any words: nothing outside -2^30 .. 2^30-1 (see checked_drive.py)."""

import json
import subprocess
import sys

from shared.record import pack
from tests import ROOT

from .imu import block as attitude_block
from .robots import block


def drive(params, ticks):
    """Run the driver on these planner blocks; returns the finished process."""
    asked = {"params": [pack(one) for one in params], "attitudes": [pack(attitude_block())], "ticks": ticks}
    command = [sys.executable, "-m", "tests.shared.checked_drive"]
    return subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, cwd=ROOT, timeout=300)


def fast(params):
    """Return a block that stands up quickly, so that more of the ticks walk."""
    params.joint_speed_slow = 4000
    return params


def test_no_word_in_command_or_senses_leaves_30_bits():
    blocks = [fast(block("caramelo", 50)), fast(block("parallel", 20)), fast(block("long-leg", 500))]
    run = drive(blocks, 1500)
    assert run.returncode == 0, run.stderr[-2000:]
    assert json.loads(run.stdout)["largest"] < 1 << 30


def test_a_leg_too_long_for_its_unit_is_caught():
    """The check can fail: a reach of 40 000 units has a square beyond 30 bits."""
    spoiled = fast(block("caramelo"))
    for leg in range(4):
        spoiled.legs[leg].longest = 40000
    run = drive([spoiled], 400)
    assert run.returncode != 0
    assert "outside -2^30 .. 2^30-1" in run.stderr
