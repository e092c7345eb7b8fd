"""Driving the robot: command sources, one arbiter, one loop at a fixed rate."""
