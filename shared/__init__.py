"""The control core: integers only, no allocation per tick, one source for CPython and MicroPython.

Nothing here imports anything outside this package. See docs/core.md for the rules.
"""
