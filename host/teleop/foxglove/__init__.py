"""Foxglove's viewers: a server in a process of its own."""
