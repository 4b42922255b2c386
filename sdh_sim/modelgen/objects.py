"""Write the grasp objects' MJCF and meshes: `python -m sdh_sim.modelgen.objects [FOLDER]`.

The same input always gives the same files; a test compares them with the committed ones.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from sdh_sim.modelgen import lofts
from sdh_sim.modelgen.object_parts import Array, Facts, Shape, numbers
from sdh_sim.modelgen.object_shapes import box, cylindrical_bottle, oval_bottle
from sdh_sim.modelgen.spray_bottle import spray_bottle

HALF = np.sqrt(0.5)
# pose_table_object: the quaternion w x y z that turns the object's `up` axis to the world's z.
STANDING = {"z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, HALF, 0.0, 0.0)}
UPRIGHT_SITE = {"z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, -HALF, 0.0, 0.0)}


def _centred(mass, friction, com, extents, up) -> Facts:
    half = tuple(e / 2e3 for e in extents)
    low = tuple(-h for h in half)
    return Facts(mass, friction, tuple(c / 1e3 for c in com), low, half, up)


# Krug et al. 2017, public data of the paper (models/objects/README.md says how to read them).
FACTS: dict[str, Facts] = {
    "box": Facts(
        mass=0.831,
        friction=0.63,
        com=(-0.00034, 0.01162, -0.00830),
        low=(-0.03595, -0.08505, -0.0776),
        high=(0.03525, 0.10825, 0.0610),
        up="y",
    ),
    "oval_bottle": _centred(0.785, 0.63, (0.52, 7.26, 12.68), (60.6, 93.3, 272.8), "z"),
    "spray_bottle": _centred(0.634, 0.68, (-0.82, 1.20, 7.44), (58.8, 91.6, 244.3), "z"),
    "cylindrical_bottle": _centred(0.556, 0.60, (-2.36, -19.93, 1.36), (69.5, 210.2, 68.9), "y"),
}
SHAPES: dict[str, Callable[[Facts], Shape]] = {
    "box": box,
    "oval_bottle": oval_bottle,
    "spray_bottle": spray_bottle,
    "cylindrical_bottle": cylindrical_bottle,
}


def build(name: str) -> tuple[Facts, Shape]:
    """Facts and shape of one object. Raises KeyError for a name that is not in FACTS."""
    return FACTS[name], SHAPES[name](FACTS[name])


def inertia(facts: Facts, shape: Shape) -> Array:
    """Inertia (3, 3) [kg m²] of a homogeneous solid of the outer shape, about its own centroid."""
    _, matrix = lofts.solid_inertia(shape.outer, facts.mass)
    matrix = np.where(np.abs(matrix) < 1e-4 * np.trace(matrix), 0.0, matrix)
    return (matrix + matrix.T) / 2


def mjcf(name: str, facts: Facts, shape: Shape) -> str:
    """MJCF text of one object: a body without a joint that stands on z = 0 at the origin."""
    matrix = inertia(facts, shape)
    full = [*np.diag(matrix), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
    up = "xyz".index(facts.up)
    base = np.zeros(3)
    base[up] = facts.low[up]
    colours = list(dict.fromkeys((v.rgba, v.shininess) for v in shape.visuals))
    materials = [
        f'    <material name="{name}_{i}" rgba="{numbers(rgba)}" specular="0.4" '
        f'shininess="{numbers(shininess)}"/>'
        for i, (rgba, shininess) in enumerate(colours)
    ]
    files = [f"visual_{v.name}" for v in shape.visuals]
    files += [f"collision_{s.name}" for s in shape.solids if not s.primitive]
    meshes = [f'    <mesh name="{f}" file="{f}.obj" inertia="shell"/>' for f in files]
    geoms = [
        f'      <geom name="visual_{v.name}" class="visual" mesh="visual_{v.name}" '
        f'material="{name}_{colours.index((v.rgba, v.shininess))}"/>'
        for v in shape.visuals
    ]
    geoms += [
        f'      <geom name="collision_{s.name}" class="collision" '
        + (s.primitive or f'type="mesh" mesh="collision_{s.name}"')
        + "/>"
        for s in shape.solids
    ]
    lines = [
        "<!-- Written by `python -m sdh_sim.modelgen.objects`: change that, not this file. -->",
        f'<mujoco model="{name}">',
        '  <compiler angle="radian" meshdir="assets"/>',
        "  <default>",
        '    <default class="visual">',
        '      <geom type="mesh" group="2" contype="0" conaffinity="0"/>',
        "    </default>",
        '    <default class="collision">',
        '      <geom group="3" contype="1" conaffinity="15" condim="3"',
        f'        friction="{numbers(facts.friction)} 0.005 0.0001" rgba="0.9 0.4 0.4 0.5"/>',
        "    </default>",
        "  </default>",
        "  <asset>",
        *materials,
        *meshes,
        "  </asset>",
        "  <worldbody>",
        "    <!-- No joint: the scene adds a free joint. The pose is how it stands on z = 0. -->",
        f'    <body name="object" pos="0 0 {numbers(-facts.low[up])}" '
        f'quat="{numbers(STANDING[facts.up], 17)}">',
        f'      <inertial mass="{numbers(facts.mass)}" pos="{numbers(facts.com)}"',
        f'        fullinertia="{numbers(full, 6)}"/>',
        *geoms,
        f'      <site name="base" pos="{numbers(base)}" '
        f'quat="{numbers(UPRIGHT_SITE[facts.up], 17)}" size="0.005" group="4"/>',
        "    </body>",
        "  </worldbody>",
        "</mujoco>",
    ]
    return "\n".join(lines) + "\n"


def write(folder: Path) -> None:
    """Write every object below `folder` as NAME/NAME.xml and NAME/assets/*.obj."""
    for name in FACTS:
        facts, shape = build(name)
        assets = folder / name / "assets"
        for visual in shape.visuals:
            lofts.write_obj(assets / f"visual_{visual.name}.obj", visual.mesh)
        for solid in shape.solids:
            if not solid.primitive:
                lofts.write_obj(assets / f"collision_{solid.name}.obj", solid.mesh)
        lofts.write_obj(assets / f"{name}.obj", shape.outer)
        (folder / name / f"{name}.xml").write_text(
            mjcf(name, facts, shape), encoding="ascii", newline="\n"
        )


if __name__ == "__main__":
    checkout = Path(__file__).resolve().parents[2]
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else checkout / "models" / "objects")
