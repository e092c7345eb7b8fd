"""First file that runs: chooses the slot of firmware to start (slots.py). Never needs to change."""

from firmware.slots import choose

choose()
