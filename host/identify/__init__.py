"""Measures a robot's servos: moves them in known ways, keeps records, and fits the numbers of the robot file."""
