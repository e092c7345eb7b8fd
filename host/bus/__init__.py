"""The ways to the joints: one interface, servos or joints on CAN behind it."""
