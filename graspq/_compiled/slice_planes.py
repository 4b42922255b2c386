"""Compiled: the plane that stops a ray."""

from __future__ import annotations

import numpy as np

from graspq._compiled.jit import entry
from graspq._compiled.ray_shooting import extent, shoot
from graspq._compiled.small_matrices import row_sum
from graspq._compiled.workspace import INVERSE, clear, new_desk


@entry
def stops(rays, body, pads, stop, reaches, planes):
    """Reach and supporting plane u (u·x <= 1) of every ray (6, m); False when one failed."""
    desk = new_desk(body[0].shape[1], body[1].shape[0] - 1)
    clear(desk, body)
    size, ray, u = np.empty(6), np.empty(6), np.empty(6)
    extent(body, size)
    for j in range(rays.shape[1]):
        for r in range(6):
            ray[r] = rays[r, j]
        status, value, _, _ = shoot(desk, ray, size, body, pads, stop)
        if status != 0:
            reaches[j] = 0.0
            return False
        row_sum(desk.sheet[INVERSE : INVERSE + 6], u)
        reaches[j] = value
        for r in range(6):
            planes[j, r] = u[r]
    return True
