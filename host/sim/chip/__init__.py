"""A model of the STM32F405 read out of its reference manual, for running driver code on a computer."""

from .chip import Chip
from .registers import Complaint

__all__ = ["Chip", "Complaint"]
