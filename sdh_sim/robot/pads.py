"""Tactile pads: arrays of taxels, and where they are on the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Frame:
    """A frame of its own in a body, for a pad or the palm; the model gets a fixed body for it.

    Attributes:
        body: that carries it.
        pos: its origin in that body (3,) [m].
        quat: its axes in that body, w x y z (4,).
    """

    body: str
    pos: tuple[float, ...]
    quat: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class TaxelArray:
    """One kind of tactile array.

    Row 0 is that at the tip; columns go along the y axis of the link. The surface is a profile
    along the rows, the same in every column.

    Attributes:
        kind: name of the kind.
        pitch: distance between neighbouring columns [m].
        profile: per row x [mm], z [mm] in the link frame and tilt of the normal [deg], which is
            (cos tilt, 0, sin tilt), (rows, 3).
        live: which taxels exist (rows, columns) bool.
    """

    kind: str
    pitch: float
    profile: np.ndarray
    live: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.live.shape[0], self.live.shape[1]

    def surface(self, row: float, column: float) -> tuple[np.ndarray, np.ndarray]:
        """Point and outward normal at a (fractional) row and column, in the link frame.

        Args:
            row: 0 (tip end) to rows - 1; between two rows the profile is interpolated.
            column: 0 to columns - 1.

        Returns:
            position (3,) [m] and unit normal (3,), away from the finger.
        """
        rows = np.arange(len(self.profile))
        x, z, tilt = (float(np.interp(row, rows, self.profile[:, k])) for k in range(3))
        y = (column - 0.5 * (self.live.shape[1] - 1)) * self.pitch
        t = math.radians(tilt)
        return np.array([x * 1e-3, y, z * 1e-3]), np.array([math.cos(t), 0.0, math.sin(t)])

    @cached_property
    def centres(self) -> np.ndarray:
        """Taxel centres on the surface in the link frame, (rows, columns, 3) [m], read-only."""
        rows, columns = map(range, self.shape)
        centres = np.array([[self.surface(r, k)[0] for k in columns] for r in rows])
        centres.setflags(write=False)
        return centres


@dataclass(frozen=True)
class Pad:
    """One tactile array on a link.

    Attributes:
        name: of the pad.
        body: whose frame is the pad's: x out of the pad, z toward row 0.
        array: what it is.
        frame: where that body is in the link; None: it is the link itself.
        replaces: geoms of the link whose contacts the taxels take over, by name.
    """

    name: str
    body: str
    array: TaxelArray
    frame: Frame | None = None
    replaces: tuple[str, ...] = ()
