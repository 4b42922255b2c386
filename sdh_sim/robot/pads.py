"""The tactile pads as a device: which taxels there are, where, and in what order they are read."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sdh_sim.robot import sdh2_constants as c

PAD_NAMES = tuple(f"{finger}_{kind}" for finger, kind in c.PADS)


def pad_table() -> list[tuple[str, int, int, int, float]]:
    """Rows (pad, rows, columns, live taxels, pitch [mm])."""
    return [
        (name, c.TAXEL_ROWS[kind], c.TAXEL_COLUMNS, int(live_mask(kind).sum()), c.TAXEL_PITCH * 1e3)
        for name, (_, kind) in zip(PAD_NAMES, c.PADS, strict=True)
    ]


@lru_cache
def live_mask(kind: str) -> np.ndarray:
    """Which taxels of a pad exist, bool (rows, 6), read-only."""
    rows, columns = range(c.TAXEL_ROWS[kind]), range(c.TAXEL_COLUMNS)
    mask = np.array([[c.taxel_is_live(kind, r, k) for k in columns] for r in rows])
    mask.setflags(write=False)
    return mask


@lru_cache
def taxel_centres(kind: str) -> np.ndarray:
    """Taxel centres on the pad surface in the link frame, (rows, 6, 3) [m], read-only."""
    rows, columns = range(c.TAXEL_ROWS[kind]), range(c.TAXEL_COLUMNS)
    centres = np.array([[c.pad_surface(kind, r, k)[0] for k in columns] for r in rows])
    centres.setflags(write=False)
    return centres


# Offset of each pad in the flat tactile vector: pads in the order of PADS, row by row.
PAD_OFFSETS = np.cumsum([0] + [c.TAXEL_ROWS[kind] * c.TAXEL_COLUMNS for _, kind in c.PADS])


TACTILE_SIZE = int(PAD_OFFSETS[-1])  # 486


def arrays(flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The flat tactile vector as arrays: proximal (3, 14, 6), distal (3, 13, 6)."""
    middle = PAD_OFFSETS[3]
    return (
        flat[:middle].reshape(3, c.TAXEL_ROWS["proximal"], c.TAXEL_COLUMNS),
        flat[middle:].reshape(3, c.TAXEL_ROWS["distal"], c.TAXEL_COLUMNS),
    )
