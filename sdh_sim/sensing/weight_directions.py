"""An object's weight: how large, and along which directions where no table says what is down."""

from __future__ import annotations

import numpy as np

from sdh_sim.settings import GRAVITY_DIRECTIONS

GRAVITY = 9.81  # [m/s^2]


def directions_of(gravity: str) -> tuple[str, ...]:
    """The directions that a setting ``gravity`` asks for, each a member of GRAVITY_DIRECTIONS."""
    return GRAVITY_DIRECTIONS if gravity == "six" else (gravity,)


def unit_vector(direction: str) -> np.ndarray:
    """Unit vector (3,) of a member of GRAVITY_DIRECTIONS, in the object's frame."""
    vector = np.zeros(3)
    vector["xyz".index(direction[1])] = -1.0 if direction[0] == "-" else 1.0
    return vector
