"""Frozen as the board's main module: MicroPython runs it once USB is up."""

from firmware.startup import start

start.settle()
start.run()
