"""Ways to a CAN bus: python-can's adapters, and a bus in simulated time."""
