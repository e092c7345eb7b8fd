"""Records of what the robot did: MCAP files, written while it runs, looked at and replayed afterwards."""
