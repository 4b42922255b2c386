"""One increment of a quasi-static motion: contacts with dry friction, and bounded springs.

The unknown is the motion z (n,) of all coordinates within the increment. Balance of generalised
forces, with a small viscosity D that lets what nothing holds move by a finite amount:

    Σ J_cᵀ (n_c N_c + t_c) + Σ r fᵣ + load - D z = 0

- a contact presses with N = k max(0, -gap - n·J z);
- its friction force is the trial force t₀ - k (I - n nᵀ) J z where that is shorter than μ N, else
  that force shortened to μ N. t₀ is the friction force at the end of the increment before: the
  return mapping of plasticity (Simo, Hughes: Computational Inelasticity, 1998, chapter 2; for
  friction Wriggers: Computational Contact Mechanics, 2006, chapters 5 and 10). So a contact that
  sticks is an elastic spring that does not creep, and one that slips dissipates as Coulomb says;
- a bounded spring pulls along its row r with clip(f₀ - k r·z, lower, upper): a position servo with
  its torque limit, an end stop (lower bound 0), a spring or a coupling (no bounds).

Newton's method (``balance``) with the exact tangent, which friction makes non-symmetric.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sdh_sim.settling.balance import balanced_motion


class Contacts(NamedTuple):
    """Contacts between two bodies each, n coordinates.

    Attributes:
        jacobian: velocity of the second body at the contact less that of the first (c, 3, n).
        normal: unit, from the first to the second (c, 3).
        gap: distance, below 0 where they overlap (c,) [m].
        stiffness: in every direction (c,) [N/m].
        friction: coefficient (c,).
        carried: friction force on the second body before the increment (c, 3) [N].
    """

    jacobian: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    stiffness: np.ndarray
    friction: np.ndarray
    carried: np.ndarray


class Springs(NamedTuple):
    """Springs with bounded force, each along a row of generalised coordinates.

    Attributes:
        rows: what their lengths change by per motion (r, n).
        force: along the row, at no motion and without bounds (r,) [N or N m].
        stiffness: (r,) [N/m or N m/rad].
        lower, upper: bounds of the force (r,).
    """

    rows: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


class Increment(NamedTuple):
    """What an increment leads to.

    Attributes:
        motion: of the coordinates (n,) [m or rad].
        normal: normal forces of the contacts (c,) [N].
        tangential: friction forces on the second bodies (c, 3) [N].
        force: of the springs (r,) [N or N m].
        factor: on the viscosity, 1 where none was needed.
    """

    motion: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    force: np.ndarray
    factor: float


def solve_increment(
    contacts: Contacts,
    springs: Springs,
    load: np.ndarray,
    viscosity: np.ndarray,
    reach: np.ndarray,
    longest: float = math.inf,
    factor: float = 1.0,
) -> Increment:
    """The motion that brings all forces into balance.

    Where it would be too long, or Newton's method does not find it, it is looked for again with a
    larger viscosity: the surfaces that were found beforehand are good for short motions alone.

    Args:
        contacts, springs: as they are before it.
        load: given generalised forces (n,) [N or N m].
        viscosity: D, diagonal (n,) [N/m or N m/rad].
        reach: length by which a unit of each coordinate moves a surface (n,) [m or 1].
        longest: no coordinate may move a surface further [m].
        factor: on the viscosity, to begin with; never below 1.
    """
    arrays = (*contacts, *springs, load, viscosity, reach)
    given = [np.ascontiguousarray(array, dtype=float) for array in arrays]
    return Increment(*balanced_motion(*given, float(longest), max(1.0, float(factor))))
