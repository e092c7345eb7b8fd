"""The controller boards: building and flashing their firmware, and the runtimes of the core."""
