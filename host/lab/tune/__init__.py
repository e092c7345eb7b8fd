"""Finds better chosen values for a robot file: walks in the simulators, an optimiser, a copy of the file."""
