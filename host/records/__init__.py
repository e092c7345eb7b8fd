"""Records of drives: MCAP files, written while the robot runs, then examined and replayed."""
