"""The robot for one's own programs: `from caramelo import Robot`."""
