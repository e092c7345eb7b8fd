"""The robot for one's own programs: what `from caramelo import Robot` gives."""
