"""The trot that feels load, ground and motion."""
