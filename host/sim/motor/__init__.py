"""A simulated brushless joint: the motor, gear and board model under the joint's own firmware."""
