"""The only file that knows which Python runs it.

The core is plain Python. Six names carry what a MicroPython build needs to know about it:

``const``  marks a private module constant, which MicroPython folds at compile time.
``hot``    marks a function of the inner loops. It is the identity here; the firmware build
           (host/build) rewrites it to ``@micropython.viper`` or ``@micropython.native``.
``ptr16``  and ``ptr32`` alias an array inside a hot function for fast element access. They are
           the identity here and raw pointers in viper: ptr16 reads unsigned, ptr32 signed.
``zeros``  makes the array that state lives in, and ``table`` one of numbers that never change.
"""

from array import array
from sys import implementation

_CPYTHON = implementation.name == "cpython"


def const(value):
    """Return ``value``: MicroPython's compiler replaces ``_NAME = const(...)`` by the number."""
    return value


def hot(function):
    """Return ``function`` unchanged: the firmware build turns this mark into an emitter."""
    return function


def ptr16(block):
    """Return ``block``: in viper a pointer to unsigned 16-bit elements."""
    return block


def ptr32(block):
    """Return ``block``: in viper a pointer to signed 32-bit elements."""
    return block


def zeros(size):
    """Return ``size`` integers, all 0, in what this Python reads and writes fastest. Allocates: not for ticks.

    That is a list on CPython, four times as fast there as an array of machine words, which ptr32 needs in viper.
    """
    if _CPYTHON:
        return [0] * size
    return array("i", [0] * size)


def table(values):
    """Return ``values``, each 0 .. 65535, to be read through ptr16: a tuple on CPython, for the same reason."""
    if _CPYTHON:
        return values
    return array("H", values)
