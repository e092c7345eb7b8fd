"""Tests of the chip model, each from the manual."""
