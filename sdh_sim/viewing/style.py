"""Scales, colours and names that the entities of a recording and its layout share."""

from __future__ import annotations

import numpy as np

TIMELINE = "sim_time"
WRENCH_SPACE = "wrench_space"  # entity above those of the wrench space
FULL_SCALE = 2.0  # taxel force at the bright end of every colour map [N]
FORCE_SCALE = 0.006  # length of a contact force's arrow [m/N]
LIMIT_SCALE = 0.002  # length of the arrows at perceived contacts: g*, least forces [m/N]

MOTOR_COLORS = [
    (120, 120, 120), (220, 60, 60), (250, 160, 120), (60, 90, 220), (120, 190, 250),
    (40, 150, 70), (160, 220, 110),
]  # fmt: skip
# Of the limits of the motors' groups.
LIMIT_COLORS = ((255, 60, 200), (255, 150, 0), (90, 200, 90), (150, 110, 250))

# Red, green, blue of a taxel from no force to full scale.
_HEAT = np.array([(45, 45, 55), (120, 30, 110), (220, 60, 60), (250, 160, 30), (255, 250, 150)])


def heat_colors(force: np.ndarray) -> np.ndarray:
    """Colours 0xRRGGBBAA, uint32, of forces [N]; both of the same shape."""
    share = np.sqrt(np.clip(force / FULL_SCALE, 0.0, 1.0))  # so that small forces show
    stops = np.linspace(0.0, 1.0, len(_HEAT))
    rgb = [np.interp(share, stops, _HEAT[:, k]).astype(np.uint32) for k in range(3)]
    return (rgb[0] << 24) | (rgb[1] << 16) | (rgb[2] << 8) | np.uint32(255)
