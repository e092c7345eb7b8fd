"""The ways to the joints: one class per kind of bus behind base.Bus."""
