"""Figures of teleoperation, measured from outside on the whole command."""
