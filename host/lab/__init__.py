"""What measures and proves: parity, experiments, benches, figures. The robot runs without it."""
