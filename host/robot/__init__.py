"""The robot file: its checks, and what follows from it alone: integers of the core, poses, drives, gains, heat."""
