"""Compiled: the plane that stops a ray."""

from __future__ import annotations

import numpy as np

from graspq._climb import new_list
from graspq._jit import entry
from graspq._pivot import new_state, row_sum
from graspq._ray import extent, shoot


@entry
def stops(rays, body, pads, stop, reaches, planes):
    """Reach and supporting plane u (u·x <= 1) of every ray (6, m); False when one failed."""
    score, choice = np.empty(body[0].shape[1]), np.empty(body[1].shape[0] - 1, np.int64)
    state = new_state(choice.shape[0])
    short = new_list(score.shape[0], choice.shape[0])
    size, ray, u = np.empty(6), np.empty(6), np.empty(6)
    extent(body, size)
    for j in range(rays.shape[1]):
        for r in range(6):
            ray[r] = rays[r, j]
        status, value, _, _ = shoot(state, ray, size, body, pads, stop, score, choice, short)
        if status != 0:
            reaches[j] = 0.0
            return False
        row_sum(state[1], u)
        reaches[j] = value
        for r in range(6):
            planes[j, r] = u[r]
    return True
