"""The check in three dimensions: MuJoCo moves the exported model, the planner drives it; needs the extra `test`."""
