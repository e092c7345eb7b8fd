"""Simulated joints on CAN: the firmware's own application on a simulated board, and the robot they move."""
