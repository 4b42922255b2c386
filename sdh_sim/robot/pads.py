"""Tactile pads: arrays of taxels, and where they are on the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

_SIDES = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])  # of a taxel, rows and columns
_CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])  # of a square, rows and columns


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

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        """Where points near the surface lie on the array: the inverse of ``surface``.

        A point is projected on the profile, perpendicularly; the profile goes on straight beyond
        its ends.

        Args:
            points: in the link frame (n, 3) [m].

        Returns:
            fractional rows and columns (n, 2); beyond the outermost centres they go on, so that
            the array ends half a pitch further out, at -0.5 and at rows - 0.5.
        """
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        starts, steps = self._segments
        # For every point and segment, how far along the segment the nearest place lies.
        along = points[:, None, ::2] - starts
        length = np.maximum((steps**2).sum(axis=1), 1e-18)  # of rows in one place: 0
        share = (along * steps).sum(axis=2) / length
        low, high = np.zeros(len(starts)), np.ones(len(starts))
        low[0], high[-1] = -np.inf, np.inf
        share = np.clip(share, low, high)
        away = ((along - share[:, :, None] * steps) ** 2).sum(axis=2)
        nearest = away.argmin(axis=1)
        rows = nearest + share[np.arange(len(points)), nearest]
        return np.column_stack((rows, points[:, 1] / self.pitch + 0.5 * (self.live.shape[1] - 1)))

    def shares(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which taxels feel what acts at points near the surface, and how much of it each.

        The four centres around a point share it bilinearly, so that neither the sum of forces nor
        their centre changes. In the outer half of a taxel at the border, or beside a missing one,
        the taxels that there are take the others' part: the force is felt whole, at most half a
        pitch off. A point on no taxel is felt by nobody.

        Args:
            points: in the link frame (n, 3) [m].

        Returns:
            flat indices into the array (n, 4), and shares (n, 4), which sum to 1, or to 0 where
            the point lies on no taxel.
        """
        at = self.coordinates(points)
        low = np.floor(at).astype(np.int64)
        cells, there = self._cells(low[:, None, :] + _CORNERS)
        _, on_array = self._cells(np.floor(at + 0.5).astype(np.int64))
        beyond = (at - low)[:, None, :]
        share = np.where(there, np.prod(np.where(_CORNERS, beyond, 1.0 - beyond), axis=2), 0.0)
        whole = np.where(on_array, share.sum(axis=1), np.inf)  # the point's own taxel has a quarter
        return cells, share / whole[:, None]

    def beside(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which taxels lie beside points near the surface under which there is none.

        Args:
            points: in the link frame (n, 3) [m].

        Returns:
            flat indices into the array (n, 4), and which of them lie beside the point (n, 4): those
            that share an edge with its place, none where the point lies on a taxel itself.
        """
        place = np.floor(self.coordinates(points) + 0.5).astype(np.int64)
        _, on_array = self._cells(place)
        cells, there = self._cells(place[:, None, :] + _SIDES)
        return cells, there & ~on_array[:, None]

    def _cells(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Flat indices of rows and columns (..., 2) of any value, and whether a taxel is there."""
        rows, columns = np.moveaxis(places, -1, 0)
        last_row, last_column = self.shape[0] - 1, self.shape[1] - 1
        row, column = np.clip(rows, 0, last_row), np.clip(columns, 0, last_column)
        there = (row == rows) & (column == columns) & self.live[row, column]
        return row * self.shape[1] + column, there

    @cached_property
    def _segments(self) -> tuple[np.ndarray, np.ndarray]:
        """The profile from row to row: starts (k, 2) and steps (k, 2) in x and z [m]."""
        corners = 1e-3 * self.profile[:, :2]
        if len(corners) > 1:
            return corners[:-1], np.diff(corners, axis=0)
        tilt = math.radians(self.profile[0, 2])
        return corners, self.pitch * np.array([[math.sin(tilt), -math.cos(tilt)]])

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
