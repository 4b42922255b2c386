"""Numbers of the parallel jaw, each in one place.

A gripper of our own making: no product is copied. ``models/parallel_jaw/README.md`` says for each
number whether it is published for grippers of its class or assumed. SI units.

Frames: the palm frame lies in the front face of the guide, z out of it, x along the stroke. A jaw's
frame has x out of its pad, towards the other jaw, and z along the finger; its origin lies in the
front face of the guide. The left jaw is on the side of negative x and its axes are the palm's; the
right one is turned by half a turn about z.
"""

from __future__ import annotations

import numpy as np

# --- motion and motor ------------------------------------------------------------------------

STROKE = 0.070  # of each jaw; the pads are twice that apart when open [m]
RATED_FORCE = 100.0  # of the motor, along the stroke; each pad presses with half of it [N]
MAX_SPEED = 0.125  # of a jaw [m/s]
CLOSING_SPEED = 0.050  # of a jaw while it closes on an object [m/s]
ARMATURE = 1.9  # half of the motor's reflected inertia, at each jaw [kg]
DAMPING = 60.0  # viscous, of the whole drive, at the jaw that the motor moves [N s/m]
SERVO_STIFFNESS, SERVO_DAMPING = 5e3, 210.0  # gains kp [N/m] and kv [N s/m]
# The reference may go on past where the pads meet, so that a thin object is gripped as firmly: by
# what 1.25 times the rated force asks of the servo.
OVERTRAVEL = 1.25 * RATED_FORCE / SERVO_STIFFNESS

# --- shape: lengths in the palm frame or a jaw's [m] ------------------------------------------

Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # two opposite corners

MOUNT_HEIGHT = 0.120  # mounting face to palm frame
NECK_RADIUS, NECK_TOP = 0.0315, -0.104  # adapter that ends at z = -MOUNT_HEIGHT
HOUSING: Box = ((-0.060, -0.0375, -0.105), (0.060, 0.0375, -0.030))  # of motor and gears
GUIDE: Box = ((-0.100, -0.026, -0.036), (0.100, 0.026, 0.0))  # that the jaws slide on
CARRIAGE: Box = ((-0.016, -0.021, 0.001), (0.009, 0.021, 0.022))  # foot of a jaw

FINGER_LENGTH = 0.108  # palm frame to tip
FINGER_FRONT, FINGER_BACK = 0.009, -0.014  # x of the finger's front and back
FINGER_HALF_WIDTH = 0.014
TAPER_START, TIP_BACK = (
    0.070,
    -0.006,
)  # the back runs straight from there to x = TIP_BACK at the tip

PAD_THICKNESS = 0.003  # rubber before the finger's front
PAD_HALF_WIDTH = 0.011
PAD_SPAN = (0.056, 0.104)  # z of the pad's ends

# --- tactile array ----------------------------------------------------------------------------

TAXEL_PITCH = 3.4e-3
TAXEL_ROWS, TAXEL_COLUMNS = 14, 6
PAD_SURFACE = FINGER_FRONT + PAD_THICKNESS  # x
# Per row from the tip (row 0) down: x [mm], z [mm], tilt of the normal [deg].
PROFILE = np.array(
    [
        (1e3 * PAD_SURFACE, 1e3 * (0.5 * sum(PAD_SPAN) + (6.5 - row) * TAXEL_PITCH), 0.0)
        for row in range(TAXEL_ROWS)
    ]
).round(6)
PROFILE.setflags(write=False)

# --- mass [kg] --------------------------------------------------------------------------------

HOUSING_MASS, GUIDE_MASS = 0.55, 0.25
CARRIAGE_MASS, FINGER_MASS = 0.05, 0.09
FINGER: Box = (
    (FINGER_BACK, -FINGER_HALF_WIDTH, CARRIAGE[1][2]),
    (FINGER_FRONT, FINGER_HALF_WIDTH, FINGER_LENGTH),
)

# --- random grasps: from the palm to the grasp centre [m] --------------------------------------

GRASP_DEPTH = (0.062, 0.098)  # between the pads
PRECISION_DEPTH = (0.090, 0.103)  # between the four rows at the tip


def inertia(*parts: tuple[float, Box]) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass properties of homogeneous boxes joined to one body.

    Args:
        parts: mass [kg] and corners of each.

    Returns:
        mass [kg], centre of mass (3,) [m], inertia about it (3, 3) [kg m²].
    """
    masses = np.array([mass for mass, _ in parts])
    corners = np.array([box for _, box in parts])
    centres, sizes = corners.mean(axis=1), np.ptp(corners, axis=1)
    com = masses @ centres / masses.sum()
    total = np.zeros((3, 3))
    for mass, size, offset in zip(masses, sizes, centres - com, strict=True):
        total += mass / 12.0 * np.diag(size @ size - size**2)
        total += mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return float(masses.sum()), com, total


def taxel_radius(row: int, column: int) -> float:
    """Radius [m] of the sphere that stands for one taxel's rubber.

    Up to four pitches, so that neighbouring spheres overlap deeply and no edge of an object catches
    between them; but no sphere stands out of the finger, be it beside the pad, beyond the tip or
    behind.
    """
    z = 1e-3 * PROFILE[row, 1]
    beside = FINGER_HALF_WIDTH - abs(column - 0.5 * (TAXEL_COLUMNS - 1)) * TAXEL_PITCH
    taper = max(0.0, (z - TAPER_START) / (FINGER_LENGTH - TAPER_START))
    back = FINGER_BACK + taper * (TIP_BACK - FINGER_BACK)
    behind = 0.48 * (PAD_SURFACE - back)
    return min(4.0 * TAXEL_PITCH, beside, FINGER_LENGTH - z, behind)
