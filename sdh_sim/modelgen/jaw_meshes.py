"""Meshes of the parallel jaw, boxes with rounded edges around the table's dimensions."""

from __future__ import annotations

import numpy as np
import trimesh

from sdh_sim.modelgen import jaw_numbers as j
from sdh_sim.modelgen.hand_meshes import prism
from sdh_sim.modelgen.lofts import combine, cylinder, hull, rounded_box

GROOVE = 0.0015  # depth of the slot in the guide that the jaws run in [m]


def _housing() -> trimesh.Trimesh:
    low, high = j.HOUSING
    body = rounded_box(low, high, 0.012, 0.004)
    plate = rounded_box(
        (0.62 * low[0], low[1] - 0.0012, -0.095), (0.62 * high[0], high[1] + 0.0012, -0.045),
        0.005, 0.001, "y",
    )  # fmt: skip
    return combine(body, plate)


def _guide() -> trimesh.Trimesh:
    low, high = np.array(j.GUIDE)
    beam = rounded_box(low, (high[0], high[1], -GROOVE), 0.008, 0.003)
    # Two rails along the stroke, on which the carriages run.
    rails = [
        rounded_box((low[0] + 0.004, y - 0.004, -0.006), (high[0] - 0.004, y + 0.004, 0.0),
                    0.001, 0.0005, "x")
        for y in (-0.014, 0.014)
    ]  # fmt: skip
    return combine(beam, *rails)


def _neck() -> trimesh.Trimesh:
    return cylinder(j.NECK_RADIUS, -j.MOUNT_HEIGHT, j.NECK_TOP, edge=0.001)


def _carriage() -> trimesh.Trimesh:
    low, high = np.array(j.CARRIAGE)
    block = rounded_box(low, high, 0.003, 0.002)
    feet = rounded_box((low[0], low[1] + 0.002, -0.001), (high[0], high[1] - 0.002, 0.004), 0.002)
    return combine(block, feet)


def _finger() -> trimesh.Trimesh:
    """The finger's profile in (x, z), from the carriage to the tip, rounded."""
    front, back = 1e3 * j.FINGER_FRONT, 1e3 * j.FINGER_BACK
    tip, length, taper = 1e3 * j.TIP_BACK, 1e3 * j.FINGER_LENGTH, 1e3 * j.TAPER_START
    corners = [
        (front - 2.0, 22.0, 2.0), (front - 2.0, length - 2.0, 2.0), (tip + 3.0, length - 3.0, 3.0),
        (back + 3.0, taper, 3.0), (back + 3.0, 22.0, 3.0),
    ]  # fmt: skip
    width = 1e3 * j.FINGER_HALF_WIDTH
    return prism(corners, (-width, width), 2.0)


def _finger_core() -> trimesh.Trimesh:
    """Convex body of the finger, for contacts."""
    profile = [
        (j.FINGER_FRONT, j.CARRIAGE[1][2]),
        (j.FINGER_FRONT, j.FINGER_LENGTH),
        (j.TIP_BACK, j.FINGER_LENGTH),
        (j.FINGER_BACK, j.TAPER_START),
        (j.FINGER_BACK, j.CARRIAGE[1][2]),
    ]
    width = j.FINGER_HALF_WIDTH
    return hull(np.array([(x, y, z) for x, z in profile for y in (-width, width)]))


def _pad() -> trimesh.Trimesh:
    low = (j.FINGER_FRONT - 0.001, -j.PAD_HALF_WIDTH, j.PAD_SPAN[0])
    high = (j.PAD_SURFACE - 1e-4, j.PAD_HALF_WIDTH, j.PAD_SPAN[1])
    return rounded_box(low, high, 0.002, 0.0008, "x")


def jaw_meshes() -> dict[str, trimesh.Trimesh]:
    """All meshes of the gripper by name [m], deterministic."""
    return {
        "housing": _housing(),
        "guide": _guide(),
        "neck": _neck(),
        "carriage": _carriage(),
        "finger": _finger(),
        "finger_core": _finger_core(),
        "pad": _pad(),
    }
