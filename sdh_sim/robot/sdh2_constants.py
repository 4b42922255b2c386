"""Numbers of the Schunk SDH-2, each in one place, with its source.

Sources: [urdf] ipa320/schunk_modular_robotics, schunk_description; [lib] SDHLibrary-CPP;
[taxel] taxel kinematics published with peter-kiechle/tactile-sensors; [cad] measured on public
CAD meshes of the hand; [data sheet] Schunk's. Lengths in metres, angles in radians, unless
a name says otherwise. The MJCF in ``models/schunk_sdh2`` is written from this file by
``python -m sdh_sim.modelgen.hand``.

Frames: the palm frame has z out of the palm and x from the thumb towards the finger pair. A
phalanx frame sits on the joint axis, z along the phalanx, x out of the pad, y the flexion axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

# --- kinematics [urdf] -------------------------------------------------------------------------


class Finger(NamedTuple):
    """One finger: base position in the palm frame, yaw of the base, sense of the spread joint."""

    name: str
    base: tuple[float, float, float]  # [m]
    yaw: float  # [rad] of the finger base frame about the palm's z at spread 0
    spread_sign: int  # axis of the spread joint along the base's z: +1, -1; 0: no spread joint


FINGERS = (
    Finger("finger1", (0.01905, 0.033, 0.0745), math.pi, +1),
    Finger("finger2", (0.01905, -0.033, 0.0745), math.pi, -1),
    Finger("thumb", (-0.03811, 0.0, 0.0745), 0.0, 0),
)
MOUNT_HEIGHT = 0.0075  # mounting face to palm frame [cad: 6.5-7.5 mm; finger axes 98.5 mm up]
KNUCKLE_HEIGHT = 0.0165  # finger base to proximal axis
PROXIMAL_LENGTH = 0.0865  # proximal axis to distal axis
DISTAL_LENGTH = 0.0685  # distal axis to fingertip

SPREAD_RANGE = (0.0, math.pi / 2)
PHALANX_RANGE = (-math.pi / 2, math.pi / 2)


class Motor(NamedTuple):
    """One of the 7 motors, in the order of libsdh's axes."""

    name: str
    kind: str  # spread | proximal | distal
    finger: str  # finger it moves; the spread motor turns finger1 and, coupled, finger2


MOTORS = (
    Motor("spread", "spread", "finger1"),
    Motor("finger2_proximal", "proximal", "finger2"),
    Motor("finger2_distal", "distal", "finger2"),
    Motor("thumb_proximal", "proximal", "thumb"),
    Motor("thumb_distal", "distal", "thumb"),
    Motor("finger1_proximal", "proximal", "finger1"),
    Motor("finger1_distal", "distal", "finger1"),
)
COUPLED_JOINT = "spread_coupled"  # finger2's base, turned by the spread motor as well

# [data sheet] 2.1 N m spread and proximal, 1.4 N m distal
DATASHEET_TORQUE = {"spread": 2.1, "proximal": 2.1, "distal": 1.4}
# [lib] greatest speeds, 86 / 200 / 158 deg/s
MAX_SPEED = {k: math.radians(v) for k, v in {"spread": 86, "proximal": 200, "distal": 158}.items()}

# --- inertia [urdf; distal centre of mass from cad] ----------------------------------------------


class Inertia(NamedTuple):
    """Mass [kg], centre of mass [m], inertia at it (Ixx, Iyy, Izz, Iyz) [kg m^2]; Ixy = Ixz = 0."""

    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float]


PALM_INERTIA = Inertia(1.0288, (0.0, 0.0, 0.0387), (1189.6e-6, 1188.9e-6, 1563.6e-6, 0.0))
KNUCKLE_INERTIA = Inertia(0.047, (0.0, 0.00221, 0.01216), (16.07e-6, 7.01e-6, 15.08e-6, -0.48e-6))
PROXIMAL_INERTIA = Inertia(
    0.167, (0.00075, -0.00004, 0.04302), (158.3e-6, 158.2e-6, 19.04e-6, 9.26e-6)
)
DISTAL_INERTIA = Inertia(
    0.0929, (0.00099, 0.00200, 0.03159), (42.32e-6, 39.74e-6, 11.22e-6, 5.80e-6)
)
TOTAL_MASS = 1.0288 + 3 * (0.047 + 0.167 + 0.0929)  # 1.95 kg

# --- tactile arrays [taxel] ----------------------------------------------------------------------

TAXEL_PITCH = 3.4e-3
TAXEL_COLUMNS = 6
TAXEL_ROWS = {"proximal": 14, "distal": 13}
MASKED_ROWS = 5  # distal rows 0..4 (the tip end) have no taxel in the first and the last column

# Distal pad, one line a row from the tip (row 0) down: x [mm], z [mm], tilt of the normal [deg];
# the normal is (cos t, 0, sin t).
DISTAL_PROFILE = np.array(
    [
        (7.75, 62.07, 28.55),
        (9.28, 59.04, 25.19),
        (10.64, 55.92, 21.83),
        (11.81, 52.73, 18.47),
        (12.79, 49.47, 15.11),
        (13.58, 46.17, 11.76),
        (14.18, 42.82, 8.40),
        (14.58, 39.44, 5.04),
        (14.78, 36.05, 1.68),
        (14.80, 32.65, 0.0),
        (14.80, 29.25, 0.0),
        (14.80, 25.85, 0.0),
        (14.80, 22.45, 0.0),
    ]
)
# Proximal pad: flat, x = 15.4 mm, z = 21.6 + (13 - row) 3.4 mm.
PROXIMAL_PROFILE = np.array([(15.4, 21.6 + (13 - row) * 3.4, 0.0) for row in range(14)])
PAD_PROFILE = {"proximal": PROXIMAL_PROFILE, "distal": DISTAL_PROFILE}
for _profile in PAD_PROFILE.values():
    _profile.setflags(write=False)

# Pads in the order of every tactile array: fingers as in FINGERS.
PADS = tuple((f.name, kind) for kind in ("proximal", "distal") for f in FINGERS)


def taxel_is_live(kind: str, row: int, column: int) -> bool:
    """Whether the taxel exists: 84 of 84 on a proximal pad, 68 of 78 on a distal one."""
    return kind == "proximal" or row >= MASKED_ROWS or 0 < column < TAXEL_COLUMNS - 1


def pad_surface(kind: str, row: float, column: float) -> tuple[np.ndarray, np.ndarray]:
    """Point and outward normal of a pad at a (fractional) row and column, in the link frame.

    Args:
        kind: ``proximal`` or ``distal``.
        row: 0 (tip end) to rows - 1; between two rows the profile is interpolated.
        column: 0 to 5.

    Returns:
        position (3,) [m] and unit normal (3,), away from the finger.
    """
    profile = PAD_PROFILE[kind]
    rows = np.arange(len(profile))
    x, z, tilt = (float(np.interp(row, rows, profile[:, k])) for k in range(3))
    y = (column - 0.5 * (TAXEL_COLUMNS - 1)) * TAXEL_PITCH
    t = math.radians(tilt)
    return np.array([x * 1e-3, y, z * 1e-3]), np.array([math.cos(t), 0.0, math.sin(t)])


# --- preshapes used on the real hand [lib demo grasps] --------------------------------------------


class Preshape(NamedTuple):
    """Spread; proximal and distal angle as (offset, slope) of the closing ratio (1 is closed)."""

    spread: float
    proximal: tuple[float, float]
    distal: tuple[float, float]


def _preshape(spread: float, p0: float, p1: float, d0: float, d1: float) -> Preshape:
    rad = math.radians
    return Preshape(rad(spread), (rad(p0), rad(p1)), (rad(d0), rad(d1)))


PRESHAPES = {
    "parallel": _preshape(0, -75, 82, 75, -82),
    "cylindrical": _preshape(0, -30, 30, 30, 35),
    "centrical": _preshape(60, -75, 82, 75, -82),
    "spherical": _preshape(60, -40, 25, 40, 15),
}

CLOSING_RATE = 0.6  # closing ratio of a preshape per second: 49 deg/s, a quarter of the top speed
# The quickest phalanx of a user's own closing moves as fast as that of a preshape [rad/s].
CLOSING_SPEED = CLOSING_RATE * math.radians(82)
# Motors that share a torque limit of the settings; the spread motor has that of the proximal ones.
TORQUE_GROUPS = ("proximal", "distal")

# --- where random grasps put the hand: chosen by the outcomes of trials, never by a metric --------

# Distance from the palm frame to the grasp centre [m]: precision grasps take the distal pads.
GRASP_DEPTH = {"parallel": (0.175, 0.235), "centrical": (0.175, 0.235),
               "cylindrical": (0.15, 0.215), "spherical": (0.15, 0.215)}  # fmt: skip
PRECISION_DEPTH = (0.205, 0.240)  # fingertips alone: nearer, the object meets the distal joints
PRECISION_PRESHAPES = ("parallel", "centrical")  # whose distal links stay upright
# Middle between the thumb and the finger pair along the palm's x [m]; with 60 degrees of spread
# the three fingers close on the palm's axis.
CLOSING_CENTRE = {name: 0.0 if shape.spread else -0.0095 for name, shape in PRESHAPES.items()}
