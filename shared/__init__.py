"""The control core: integers only, no allocation per tick, one source for CPython and MicroPython.

Nothing here imports anything outside this package but `array` and the name of the Python. See docs/core.md.
"""
