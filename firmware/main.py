"""Second file that runs, once USB is up: starts the firmware that boot.py chose (slots.py). Never needs to change."""

from firmware.slots import run

run()
