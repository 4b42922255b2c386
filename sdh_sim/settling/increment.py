"""One increment of a quasi-static motion: unilateral springs with dry friction, and bounded springs.

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

Newton's method with the exact tangent, which friction makes non-symmetric.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_ROUNDS = 12
_CLOSE = 1e-4  # what is left of the balance, as a share of the largest force
_AWAY = 5.0  # of Newton's method: beyond that many of the longest motions
_TRIES, _MORE = 8, 4.0  # with so many times the viscosity each time


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
    longest: float = np.inf,
    factor: float = 1.0,
) -> Increment:
    """The motion that brings all forces into balance.

    Where it would be too long, or Newton's method does not find it, it is looked for again with a
    larger viscosity: the surfaces that were found beforehand are good for short motions alone.

    Args:
        contacts, springs: as they are before it.
        load: given generalised forces (n,) [N or N m].
        viscosity: D, diagonal (n,) [N/m or N m/rad].
        reach: length that a unit of each coordinate moves things by, to compare them (n,) [m or 1].
        longest: no coordinate may move things further [m].
        factor: on the viscosity, to begin with; never below 1.
    """
    factor = max(1.0, factor)
    for _ in range(_TRIES):
        balance = _Balance(contacts, springs, load, factor * viscosity)
        z, at, balanced = _newton(balance, load, reach, longest)
        if balanced and float((np.abs(z) * reach).max()) <= longest:
            break
        factor *= _MORE
    else:
        z *= min(1.0, longest / max(float((np.abs(z) * reach).max()), 1e-12))
        at = balance.forces(z)
    return Increment(z, at.normal, at.tangential, at.force, factor)


def _newton(
    balance: _Balance, load: np.ndarray, reach: np.ndarray, longest: float
) -> tuple[np.ndarray, _Forces, bool]:
    """Motion (n,), forces there, and whether they are in balance; given up where it runs away."""
    z = np.zeros(len(load))
    at = balance.forces(z)
    size = _size(at.rest, reach)
    scale = max(size, _size(load, reach), 1e-3)
    for _ in range(_ROUNDS):
        if size <= _CLOSE * scale:
            return z, at, True
        step = np.linalg.solve(balance.tangent(at), at.rest)
        new = balance.forces(z + step)
        if _size(new.rest, reach) > size:
            step *= 0.5
            new = balance.forces(z + step)
        z, at = z + step, new
        size = _size(at.rest, reach)
        if float((np.abs(z) * reach).max()) > _AWAY * longest:
            break
    return z, at, size <= _CLOSE * scale


class _Forces(NamedTuple):
    """Forces at a motion; ``trial`` and ``length`` are those of friction before it is shortened."""

    normal: np.ndarray
    trial: np.ndarray
    length: np.ndarray
    tangential: np.ndarray
    force: np.ndarray
    rest: np.ndarray


class _Balance:
    """The balance of one increment, for Newton's method; arguments as ``solve_increment``."""

    def __init__(
        self, contacts: Contacts, springs: Springs, load: np.ndarray, viscosity: np.ndarray
    ) -> None:
        self._c, self._s, self._load, self._d = contacts, springs, load, viscosity
        self._flat = contacts.jacobian.reshape(-1, len(load))
        outer = contacts.normal[:, :, None] * contacts.normal[:, None, :]
        self._outer, self._plane = outer, np.eye(3) - outer

    def forces(self, z: np.ndarray) -> _Forces:
        """All forces at a motion, and what is left of their balance."""
        c, s = self._c, self._s
        moved = (self._flat @ z).reshape(-1, 3)
        approach = (c.normal * moved).sum(axis=1)
        normal = c.stiffness * np.maximum(-c.gap - approach, 0.0)
        trial = c.carried - c.stiffness[:, None] * (moved - approach[:, None] * c.normal)
        length = np.sqrt((trial * trial).sum(axis=1))
        limit = c.friction * normal
        share = np.minimum(1.0, limit / np.maximum(length, 1e-12))
        tangential = share[:, None] * trial
        force = np.clip(s.force - s.stiffness * (s.rows @ z), s.lower, s.upper)
        rest = ((normal[:, None] * c.normal + tangential).reshape(-1) @ self._flat)
        rest += force @ s.rows + self._load - self._d * z
        return _Forces(normal, trial, length, tangential, force, rest)

    def tangent(self, at: _Forces) -> np.ndarray:
        """Minus the derivative of the balance by the motion (n, n)."""
        c, s = self._c, self._s
        bearing = at.normal > 0.0
        limit = c.friction * at.normal
        slips = at.length > limit
        along = at.trial / np.maximum(at.length, 1e-12)[:, None]
        share = np.where(slips, limit / np.maximum(at.length, 1e-12), 1.0)
        block = share[:, None, None] * self._plane + self._outer
        turn = np.where(slips, share, 0.0)[:, None] * along
        block -= turn[:, :, None] * along[:, None, :]
        drag = np.where(slips, c.friction, 0.0)[:, None] * along
        block += drag[:, :, None] * c.normal[:, None, :]
        block *= (np.where(bearing, c.stiffness, 0.0))[:, None, None]
        stiff = (block @ c.jacobian).reshape(-1, len(self._d))
        within = (at.force > s.lower) & (at.force < s.upper)
        rows = s.rows[within]
        tangent = self._flat.T @ stiff + (rows.T * s.stiffness[within]) @ rows
        tangent[np.diag_indices(len(self._d))] += self._d
        return tangent


def _size(forces: np.ndarray, reach: np.ndarray) -> float:
    """Largest of generalised forces, moments over their reach [N]."""
    return float((np.abs(forces) / reach).max())
