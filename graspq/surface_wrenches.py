"""ε as compared with the object's wrench space: that of forces anywhere on its surface.

References:
    N. S. Pollard: Parallel methods for synthesizing whole-hand grasps from generalized prototypes,
    PhD thesis, MIT 1994; C. Borst, M. Fischer and G. Hirzinger: Grasp planning: how to choose a
    suitable task wrench space, ICRA 2004 (object wrench space).
    N. Vahrenkamp, M. Kröhnert, S. Ulbrich, T. Asfour, G. Metta, R. Dillmann and G. Sandini: Simox:
    a robotics toolbox for simulation, motion and grasp planning, IAS 2012 (the ratio of both ε).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graspq.ball import epsilon
from graspq.contact_arrays import as_coefficients, as_contacts
from graspq.errors import GraspError, as_array, as_number


def unit_wrenches(
    positions: ArrayLike,
    normals: ArrayLike,
    friction: ArrayLike,
    edges: int = 8,
    *,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    length: float = 1.0,
) -> np.ndarray:
    """Return the wrenches of hard contacts at unit normal force: for each (6, edges).

    ``contact_wrenches`` for contacts given as arrays, with the same edges: force over moment
    / length.

    Args:
        positions: contacts, or points of the surface (n, 3) [m].
        normals: unit normals into the object (n, 3).
        friction: coefficient of friction, one or one per contact.
        edges: of the friction cones, at least 3.
        origin: what moments are taken about (3,) [m].
        length: what moments are divided by [m].

    Returns:
        (n, 6, edges), which is a list of wrench sets to the other functions.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    mu = as_coefficients("friction", friction, len(contacts.positions))[:, None, None]
    if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
        raise GraspError(f"edges: expected an integer >= 3, got {edges!r}")
    arms = contacts.positions - as_array("origin", origin, (3,))
    arms /= as_number("length", length, positive=True)
    first = _first_tangents(contacts.normals)
    angles = 2.0 * np.pi * np.arange(edges) / edges
    tangents = np.stack([first, np.cross(contacts.normals, first)], axis=1)
    sides = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ tangents
    forces = contacts.normals[:, None] + mu * sides
    wrenches = np.concatenate([forces, np.cross(arms[:, None], forces)], axis=2)
    return np.ascontiguousarray(wrenches.transpose(0, 2, 1))


def _first_tangents(normals: np.ndarray) -> np.ndarray:
    """What ``contact.tangent_basis`` has first, for all normals (n, 3) at once."""
    x = normals[:, :1]
    end = np.where(x >= 0.0, -1.0, 1.0)
    reflected = np.concatenate([np.ones_like(x), normals[:, 1:] / (x - end)], axis=1)
    return np.array([0.0, 1.0, 0.0]) - (end - x) / end * reflected[:, 1:2] * reflected


def relative_epsilon(wrenches: Any, surface: Any) -> float:
    """Return ε of a grasp over ε of the object's wrench space, both with the L1 bound.

    The object's wrench space is the convex hull of the wrenches of unit normal forces, with
    friction, anywhere on the surface. With as much force in sum as the grasp, it is what infinitely
    many fingers could exert. 1: the grasp resists its worst wrench as well as these do; 0: no force
    closure. High is good. Unlike ε it can be compared between objects, since size and the unit of
    moments matter to both alike. It does not see weight or the hand's limits.

    A flat part of the surface is represented exactly by its corners, since the wrench of a force
    changes linearly along it.

    Args:
        wrenches: one (6, l_i) array per contact, from ``unit_wrenches``.
        surface: the same for corners of the surface, with the same friction, origin and length.

    Raises:
        GraspError: for bad input, or a surface whose wrenches do not hold the origin (a body of
            revolution without friction cannot be turned).
    """
    return epsilon(wrenches, "l1") / surface_epsilon(surface)


def surface_epsilon(surface: Any) -> float:
    """Return ε of an object's wrench space, the denominator of ``relative_epsilon``.

    Args:
        surface: one (6, l_i) array per corner of the surface, from ``unit_wrenches``.

    Raises:
        GraspError: for bad input, or wrenches that do not hold the origin.
    """
    whole = epsilon(surface, "l1")
    if whole == 0.0:
        raise GraspError(
            "surface: its wrenches do not hold the origin, so there is no ε to compare with; give"
            " points all around the object, and friction"
        )
    return whole
