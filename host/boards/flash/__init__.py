"""Flashing: firmware onto a board over its serial prompt, into the unused slot, and back if it fails."""
