"""Measures a robot's servos: moves them in known ways, keeps records, and fits the robot file's numbers."""
