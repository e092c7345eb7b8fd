"""The inertial sensor, real, recorded or simulated, behind one interface; and the attitude from it."""
