"""The objects of the protocols, written as folders like any user's: two cylinders and a load cell.

The cylinders have the outer diameters of steel pipe of 2 and 3 inches, schedule 40, and its mass
for their length; the load cell is a button of 5 mm radius on a round body.
"""

from __future__ import annotations

import math
from pathlib import Path

STEEL = 7850.0  # [kg/m^3]
LENGTH = 0.2  # of the cylinders [m]
PIPES = {"pipe_60": (60.3, 3.91), "pipe_89": (88.9, 5.49)}  # outer diameter, wall [mm]
FRICTION = 0.6  # of steel on the pads' rubber: assumption, near the paper's objects
CELL, CELL_FRICTION = "load_cell", 1.5  # its button is rough, so that no tip slides off
BUTTON = 0.005  # radius [m]
CELL_TOP = 0.024  # from the frame of the load cell to the end of its button [m]

_MJCF = """<mujoco model="{name}">
  <worldbody>
    <body name="object">
{geoms}
    </body>
  </worldbody>
</mujoco>
"""


def pipe_mass(name: str) -> float:
    """Mass of a cylinder's length of pipe [kg]."""
    outer, wall = (1e-3 * x for x in PIPES[name])
    return STEEL * LENGTH * math.pi * wall * (outer - wall)


def write_objects(folder: Path) -> dict[str, Path]:
    """Write all of them below a folder; their folders by name.

    Raises:
        OSError: the disk refused.
    """
    found = {}
    for name, (outer, _) in PIPES.items():
        size = f"{0.5e-3 * outer:.5f} {0.5 * LENGTH:g}"
        geom = f'      <geom type="cylinder" size="{size}" rgba="0.62 0.64 0.66 1"/>'
        found[name] = _write(folder / name, geom, pipe_mass(name), FRICTION)
    geoms = (
        '      <geom type="cylinder" size="0.0125 0.0075" pos="0 0 0.0075" rgba="0.3 0.4 0.6 1"/>\n'
        f'      <geom type="sphere" size="{BUTTON:g}" pos="0 0 {CELL_TOP - BUTTON:g}"'
        ' rgba="0.9 0.9 0.9 1"/>'
    )
    found[CELL] = _write(folder / CELL, geoms, 0.05, CELL_FRICTION)
    return found


def _write(folder: Path, geoms: str, mass: float, friction: float) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    text = _MJCF.format(name=folder.name, geoms=geoms)
    (folder / f"{folder.name}.xml").write_text(text, encoding="utf-8")
    facts = f'name = "{folder.name}"\nmass = {mass:.3f}\nfriction = {friction:g}\n'
    (folder / "object.toml").write_text(facts, encoding="utf-8")
    return folder
