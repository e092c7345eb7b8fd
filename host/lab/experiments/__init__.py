"""The papers' experiments in the simulators, each beside the papers' measurements."""
