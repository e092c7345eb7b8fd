"""Helpers for every folder of the host: errors, files, processes, the console."""
