"""Standard load protocols for robot hands, run in simulation beside their closed forms."""

import sdh_sim  # noqa: F401  # before MuJoCo, which learns from it how to draw without a screen
