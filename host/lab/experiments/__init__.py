"""The papers' experiments in the simulators, each beside what the papers measured."""
