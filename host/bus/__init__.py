"""The ways to the joints: one interface with servos or joints on CAN behind it."""
