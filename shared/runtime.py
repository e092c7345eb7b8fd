"""The only file that knows which Python runs it.

The core is plain Python. Eleven names carry what a MicroPython build needs to know about it:

``const``  marks a private module constant, which MicroPython folds at compile time.
``hot``    marks a function of the inner loops. It is the identity here; the firmware build
           (host/boards/build) rewrites it to ``@micropython.viper`` or ``@micropython.native``.
``ptr8``   ``ptr16`` and ``ptr32`` alias an array inside a hot function for fast element access. They are
           the identity here and raw pointers in viper: ptr8 and ptr16 read unsigned, ptr32 signed.
``reg16``  and ``reg32`` alias a chip's registers likewise; their values may change by themselves. Here a chip model.
``bound``  binds the first arguments of a function, so that an interrupt finds its blocks.
``zeros``  makes an array for state, ``table`` and ``words`` make one of numbers that never change.
"""

from array import array
from sys import implementation

try:
    from _core import bound  # type: ignore[import-not-found]  # an image's core in C (host/boards/build/c_core.py) brings its own
except ImportError:

    def bound(function, *given):
        """Return ``function`` with its first arguments bound to ``given``. For set-up."""

        def call(*more):
            return function(*(given + more))

        return call


CPYTHON = implementation.name == "cpython"
if CPYTHON:
    Ints = list[int]  # the annotation of an array of integers
else:
    Ints = list  # type: ignore[misc,no-redef]  # MicroPython reads no annotations


def const(value):
    """Return ``value``: MicroPython's compiler replaces ``_NAME = const(...)`` by the number."""
    return value


def hot(function):
    """Return ``function`` unchanged: the firmware build turns this mark into an emitter."""
    return function


def ptr8(block):
    """Return ``block``: in viper a pointer to unsigned bytes."""
    return block


def ptr16(block):
    """Return ``block``: in viper a pointer to unsigned 16-bit elements."""
    return block


def ptr32(block):
    """Return ``block``: in viper a pointer to signed 32-bit elements."""
    return block


def reg16(chip):
    """Return the 16-bit registers of ``chip``: on the chip an address, elsewhere a model of it (host/sim/chip)."""
    return chip.halves


def reg32(chip):
    """Return the 32-bit registers of ``chip``: on the chip an address, elsewhere a model of it."""
    return chip.words


def zeros(size):
    """Return ``size`` integers, all 0, in the type that this Python reads and writes fastest. Allocates: not for ticks.

    On CPython that is a list, four times as fast there as an array of machine words, which viper's ptr32 needs.
    """
    if CPYTHON:
        return [0] * size
    return array("i", [0] * size)


def table(values):
    """Return ``values``, each 0 .. 65535, for ptr16; on CPython as a tuple, because it is faster."""
    if CPYTHON:
        return values
    return array("H", values)


def words(values):
    """Return ``values``, each of 32 bits, for ptr32; otherwise like ``table``."""
    if CPYTHON:
        return values
    return array("i", values)
