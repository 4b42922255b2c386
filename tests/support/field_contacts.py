"""Contacts that the published metrics are compared on, from closed forms."""

from __future__ import annotations

import numpy as np

# Half axes of an ellipsoid [m].
AXES = np.array([0.03, 0.04, 0.055])
# Polar angle and azimuth of contacts on it [rad].
ANGLES = {
    "ellipsoid_3": [(1.4, 0.2), (1.7, 2.4), (1.3, 4.5)],
    "ellipsoid_4": [(1.1, 0.4), (1.9, 1.8), (1.5, 3.3), (0.9, 5.2)],
    "ellipsoid_6": [(0.6, 0.1), (1.2, 1.3), (1.8, 2.2), (2.3, 3.5), (1.0, 4.4), (1.6, 5.5)],
    "one_side": [(1.0, 0.1), (1.3, 0.9), (1.6, 1.5)],
}


def field_contacts() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Places (n, 3) [m] and unit normals into the object (n, 3), by name of the grasp."""
    made = {
        "pair": (np.array([[0.03, 0, 0], [-0.03, 0, 0]]), np.array([[-1.0, 0, 0], [1.0, 0, 0]])),
        "cube": (0.025 * np.array(_AXIS), -np.array(_AXIS)),
    }
    for name, angles in ANGLES.items():
        polar, azimuth = np.array(angles).T
        ring = np.sin(polar)
        unit = np.column_stack([ring * np.cos(azimuth), ring * np.sin(azimuth), np.cos(polar)])
        normals = -unit / AXES
        made[name] = AXES * unit, normals / np.linalg.norm(normals, axis=1)[:, None]
    return made


_AXIS = [[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]]
