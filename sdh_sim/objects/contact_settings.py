"""How contacts of objects behave, and which of their geoms are drawn."""

from __future__ import annotations

CONTACT = {"contype": 1, "conaffinity": 15, "condim": 3}  # models/objects/README.md
# Time constant of contacts away from the pads and the table: hard, but resolved by the time step.
HARD_SOLREF = (0.01, 1.0)
VISUAL_GROUP, COLLISION_GROUP = 2, 3  # the second is not drawn
WATER = 1000.0  # MuJoCo's default density [kg/m^3]
