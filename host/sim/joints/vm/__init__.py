"""The part of a simulated joint that also runs inside a MicroPython VM: integers in and out, nothing of the host."""
