"""Figures of the joints on CAN."""
