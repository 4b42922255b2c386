"""A mesh as arrays, and how large the meshes of an object may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

MAX_MESH = 16 << 20  # of a file [bytes]
MAX_FACES = 100_000  # triangles of an object
MAX_PARTS = 64  # of a mesh

MeshPiece = tuple[np.ndarray, np.ndarray]
"""Vertices (n, 3) and corners of the triangles (m, 3), indices of vertices."""


def joined(pieces: Sequence[MeshPiece]) -> MeshPiece:
    """Pieces as one: vertices (n, 3), triangles (m, 3)."""
    starts = np.cumsum([0, *(len(v) for v, _ in pieces)])
    faces = [f + start for (_, f), start in zip(pieces, starts, strict=False)]
    return np.concatenate([v for v, _ in pieces]), np.concatenate(faces)
