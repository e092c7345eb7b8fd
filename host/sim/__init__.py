"""Everything that stands in for hardware: the plane, the world in space, servos, joints, motors, a chip."""
