"""Whether a shape has the size of what a hand can grasp, and in which unit it would have."""

from __future__ import annotations

import numpy as np

from sdh_sim.errors import MeshError

SIZE = (0.01, 0.5)  # the largest extent, at least and at most [m]
THINNEST = 0.005  # the smallest extent; thinner, the pads' contacts would reach through [m]
_UNITS = (
    ("metres", 1.0),
    ("millimetres", 1e-3),
    ("centimetres", 1e-2),
    ("inches", 0.0254),
    ("decimetres", 0.1),
    ("feet", 0.3048),
    ("micrometres", 1e-6),
)


def check_extents(extents: np.ndarray, scale: float | None = None) -> None:
    """Check that an object has the size of what a hand can grasp.

    Args:
        extents: along the object's axes (3,) [m].
        scale: that the file's lengths were multiplied with; None: no key scales them.

    Raises:
        MeshError: it is too large, too small or too thin; the message lists what other units
            would give, and the user chooses.
    """
    largest = float(extents.max())
    size = " × ".join(f"{e:.4g}" for e in extents)
    bounds = f"its largest side must be {1e3 * SIZE[0]:g} to {1e3 * SIZE[1]:g} mm"
    if not SIZE[0] <= largest <= SIZE[1]:
        raise MeshError(f"is {size} m large; {bounds}: {_units(extents, scale)}")
    if extents.min() < THINNEST:
        raise MeshError(f"is {size} m large; no side may be thinner than {THINNEST:g} m")


def _units(extents: np.ndarray, scale: float | None) -> str:
    """What the user can do about a wrong size, with the size in every unit that would be right."""
    in_unit = extents / (scale or 1.0)
    fits = []
    for unit, metres in _UNITS:
        largest, smallest = in_unit.max() * metres, in_unit.min() * metres
        if SIZE[0] <= largest <= SIZE[1] and smallest >= THINNEST:
            set_to = "" if scale is None else f"scale = {metres:g}, "
            fits.append(f"{unit} ({set_to}{1e3 * largest:.4g} mm)")
    if not fits:
        return "set scale" if scale is not None else "write its sizes in metres"
    listed = " or ".join(fits)
    if scale is not None:
        return f"set scale for its unit, {listed}"
    return f"its numbers look like {listed}; write sizes, positions and mesh scales in metres"
