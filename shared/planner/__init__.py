"""The whole robot, once a tick."""
