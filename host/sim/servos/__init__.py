"""Stand-ins for hardware: a bus of servos that answers packets, and the simulated body that the servos move."""
