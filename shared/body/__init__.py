"""One robot's mechanics: its parameters, legs, pose, loads and stability."""
