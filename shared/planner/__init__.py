"""The planner: the whole robot, once a tick."""
