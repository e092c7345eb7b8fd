"""From the wish to the joints: the planner in SI, arbiter, supervisor, safety, and the loop at a fixed rate."""
