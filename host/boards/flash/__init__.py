"""Flashing: firmware onto a board over its serial prompt, into the slot that is not in use, and back when it fails."""
