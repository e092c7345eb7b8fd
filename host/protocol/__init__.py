"""The CAN protocol of the joints: joints.dbc and parameters.toml are its only sources; the rest is generated."""
