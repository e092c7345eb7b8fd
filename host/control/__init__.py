"""From the driver's command to the joints: the planner in SI, arbiter, supervisor, safety, and the loop."""
