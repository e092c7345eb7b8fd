"""The robot of twelve joints on CAN: the host's side of the bus, and the simulated joints."""
