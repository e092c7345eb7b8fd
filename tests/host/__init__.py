"""Tests of host: robot files, servos, calibration, teleoperation, records."""
