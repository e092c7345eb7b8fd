"""The inertial sensor: one interface for a real one, a recorded one and a simulated one, and the attitude from it."""
