"""Gaits as tables, their clock, steps and swings."""
