"""How motors drive a hand's joints, brought to motor coordinates.

With joint coordinates q, moment arms A of the motors (motor speeds are A q̇), couplings E
(E q̇ = 0) and contact Jacobians J_q, virtual work gives the statics of any transmission

    Σ J_qᵀ f = Aᵀ τ + Eᵀ λ,      λ free: a coupling bears whatever it must.

The unknown λ leaves with the motions N that the couplings allow (E N = 0): this is the null space
method for constrained mechanisms. What is left, Nᵀ Σ J_qᵀ f = (A N)ᵀ τ, splits in two:

- along the motions (A N)⁺ that the motors drive, Σ J_mᵀ f = τ with J_m = J_q N (A N)⁺;
- along the motions P that no motor drives (A N P = 0), Σ J_pᵀ f = 0 with J_p = J_q N P: the
  forces do no work on them. Only an underactuated hand has some.

Where motors can load each other, (A N)ᵀ τ₀ = 0, any such preload τ₀ may be added to τ.

Murray, Li, Sastry: A Mathematical Introduction to Robotic Manipulation, 1994, chapters 5 and 6
(constraints, tendons); Birglen, Laliberté, Gosselin: Underactuated Robotic Hands, 2008, chapter 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Singular values below this share of the largest are zero: couplings that repeat each other, and
# motions that no motor drives. Moment arms are known to fewer digits than that.
RANK_TOLERANCE = 1e-10


class Transmission(NamedTuple):
    """The joint motions behind the motors.

    Attributes:
        driven: joint speeds per motor speed, shape (n, k).
        passive: joint speeds that couplings allow and no motor drives, shape (n, u).
        preloads: motor torques that load no joint motion, shape (k, r).
    """

    driven: np.ndarray
    passive: np.ndarray
    preloads: np.ndarray


def reduce_transmission(arms: np.ndarray, couplings: np.ndarray) -> Transmission:
    """Split the joint motions into those that motors drive and those that none does.

    Args:
        arms: moment arms A, shape (k, n): joint torques are Aᵀ τ.
        couplings: E, shape (e, n), E q̇ = 0; rows may repeat each other.
    """
    allowed = _null_space(_unit_rows(couplings)[0])
    rows, size = _unit_rows(arms)
    left, values, right = np.linalg.svd(rows @ allowed)
    rank = _rank(values)
    driven = (right[:rank].T / values[:rank]) @ left[:, :rank].T
    return Transmission(
        driven=allowed @ driven / size,
        passive=allowed @ right[rank:].T,
        preloads=left[:, rank:] / size[:, None],
    )


def _unit_rows(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows divided by their lengths, and the lengths (1 for a row of zeros)."""
    size = np.linalg.norm(matrix, axis=1)
    size[size == 0.0] = 1.0
    return matrix / size[:, None], size


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal columns that the rows of ``matrix`` are orthogonal to."""
    if len(matrix) == 0:
        return np.eye(matrix.shape[1])
    _, values, right = np.linalg.svd(matrix)
    return right[_rank(values) :].T


def _rank(values: np.ndarray) -> int:
    return int((values > RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)).sum())
