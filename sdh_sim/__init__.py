"""Tactile grasp-and-lift trials of the Schunk SDH-2 hand in MuJoCo."""

__version__ = "0.1.0"
