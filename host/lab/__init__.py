"""Measurements and proofs: parity, experiments, benches, figures. The robot runs without them."""
