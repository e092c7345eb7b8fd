"""Finds the values of a robot file that are chosen: walks in the simulators, an optimiser, a copy of the file."""
