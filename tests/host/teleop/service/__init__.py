"""Tests of the service file."""
