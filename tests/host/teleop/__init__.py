"""Tests of teleoperation."""
