"""Tests of all folders, each in a folder of the same name."""

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
