"""Losses that grasp generators minimise, as DexGraspBench evaluates them: DFC, Q1, TDG.

All take contacts as arrays and scale moments by themselves: arms are taken from the contacts' mean
and divided by their mean length (plus 1e-6 m), so the object's size does not matter, and neither
does its centre of mass. The sign of the normals does not matter as long as all point to the same
side of the surface: ``graspq.Contact`` and DexGraspBench have them into the object (MuJoCo's
normal, from the hand's geom to the object's). DexGraspBench takes half the true friction, to leave
a margin.

References:
    R. Wang et al.: DexGraspNet, ICRA 2023, after T. Liu et al.: Synthesizing diverse and physically
    stable grasps with arbitrary hand structures using differentiable force closure estimator, RA-L
    7(1), 2022 (DFC).
    J. Chen, Y. Chen, J. Zhang and H. Wang: Task-oriented dexterous hand pose synthesis using
    differentiable grasp wrench boundary estimator, IROS 2024, arXiv 2309.13586 (TDG).
    DexGraspBench, published with BODex, arXiv 2412.16490 (the three as they are here).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from graspq.ball import epsilon
from graspq.contact_arrays import (
    ContactArrays,
    as_coefficients,
    as_contacts,
    tangents_from_y,
)
from graspq.errors import GraspError, as_array

# Added to the mean length of arms [m], as DexGraspBench does against a division by 0.
LEAST_ARM = 1e-6
Q1_EDGES = 8
Q1_WORST = 2.0
DIRECTIONS = 1000


def dfc_residual(positions: ArrayLike, normals: ArrayLike) -> float:
    """Return the DFC residual: the wrench of equal normal forces of 1 at all contacts; low is good.

    |Σ (n_i, a_i × n_i)| with scaled arms a_i. 0: frictionless contacts that all press alike
    balance. It sees neither friction nor unequal forces: good grasps whose forces must differ have
    large residuals, and balanced pairs that cannot resist a twist have 0.

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), all into the object or all out of it.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    moments = np.cross(_scaled_arms(contacts), contacts.normals)
    wrench = np.concatenate([contacts.normals, moments], axis=1).sum(axis=0)
    return float(np.linalg.norm(wrench))


def scaled_epsilon(positions: ArrayLike, normals: ArrayLike, friction: ArrayLike) -> float:
    """Return ε of DexGraspBench's hull: cones of 8 edges at unit normal force, and the origin.

    The radius of the largest ball around the origin (L1 bound); 0 without force closure. High is
    good. Moments are of scaled arms. The edges' place follows from the y axis of the frame: a
    turned frame gives slightly other values.

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), all into the object or all out of it.
        friction: coefficient of friction, one or one per contact.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    mu = as_coefficients("friction", friction, len(contacts.positions))[:, None]
    arms = _scaled_arms(contacts)
    first, second = tangents_from_y(contacts.normals)
    wrenches = np.empty((len(arms), 6, Q1_EDGES))
    for k, angle in enumerate(2.0 * np.pi * np.arange(Q1_EDGES) / Q1_EDGES):
        force = contacts.normals + mu * (np.sin(angle) * first + np.cos(angle) * second)
        wrenches[:, :3, k], wrenches[:, 3:, k] = force, np.cross(arms, force)
    return epsilon(list(wrenches), "l1", unloading=True)


def dexgraspbench_q1(positions: ArrayLike, normals: ArrayLike, friction: ArrayLike) -> float:
    """Return DexGraspBench's Q1, 2 - ε of ``scaled_epsilon``, from 0 to 2; low is good.

    DexGraspBench takes the smallest distance of a facet's plane from the origin, without its sign.
    That is ε all the same: the origin is one of the hull's points, and facets meet in it where the
    cones alone do not hold it. ε above 2 counts as 2, a flat hull as ε = 0. (Its edges' angles are
    in single precision there, which is up to 1e-7 in Q1.)

    The arguments and errors are those of ``scaled_epsilon``.
    """
    return Q1_WORST - min(Q1_WORST, scaled_epsilon(positions, normals, friction))


def tdg_loss(
    positions: ArrayLike,
    normals: ArrayLike,
    friction: ArrayLike,
    directions: ArrayLike | None = None,
) -> float:
    """Return the TDG loss for forces in all directions, from 0 to 2; low is good.

    The mean, over unit forces u, of 1 - cos of the angle between (u, 0) and the wrench that the
    contacts exert together when each goes as far along u as its friction cone lets it (round cone,
    unit normal force at most). 0: they exert pure forces in every direction. The force of a
    contact whose normal points away from u fades to zero, which makes the loss smooth; a contact
    pushes along u itself where that lies in its cone. It asks for forces alone: a grasp that cannot
    resist moments can have a low loss. It does not see limits of forces or weight.

    Args:
        positions: contacts (n, 3) [m].
        normals: unit normals (n, 3), all into the object or all out of it.
        friction: coefficient of friction, one or one per contact.
        directions: unit vectors (k, 3); None: 1000 evenly spread ones, the same on every call,
            where DexGraspBench draws 1000 at random.

    Raises:
        GraspError: for bad input.
    """
    contacts = as_contacts(positions, normals)
    mu = as_coefficients("friction", friction, len(contacts.positions))[None, :, None]
    if directions is None:
        aims = spread_directions(DIRECTIONS)
    else:
        aims = as_array("directions", directions, (None, 3), "one unit vector per row")
        if len(aims) == 0:
            raise GraspError("directions: got none, expected shape (k, 3) with k >= 1")
        if (np.abs(np.linalg.norm(aims, axis=1) - 1.0) > 1e-6).any():
            raise GraspError("directions: expected unit vectors; divide each by its norm")
    along = (aims @ contacts.normals.T)[:, :, None]
    across = aims[:, None] - along * contacts.normals
    slope = np.linalg.norm(across, axis=2, keepdims=True)
    rim = contacts.normals + mu * across / np.maximum(slope, 1e-12)
    fade = slope / np.maximum(slope - 2.0 * mu * np.minimum(along, 0.0), 1e-300)
    # An angle to the normal within the cone's; then within 90°; then beyond.
    within = np.arccos(np.clip(along, -1.0, 1.0)) <= np.arctan(mu)
    inner = contacts.normals + across / np.maximum(along, 0.5 / np.sqrt(1.0 + mu * mu))
    forces = np.where(within, inner, np.where(along >= 0.0, rim, fade * rim))
    moments = np.cross(_scaled_arms(contacts), forces).sum(axis=1)
    force = forces.sum(axis=1)
    size = np.sqrt((force**2).sum(axis=1) + (moments**2).sum(axis=1))
    cosine = (force * aims).sum(axis=1) / np.maximum(size, 1e-12)
    return float((1.0 - cosine).mean())


def spread_directions(count: int) -> np.ndarray:
    """Unit vectors (count, 3), evenly spread, each with its opposite; always the same.

    Half of a Fibonacci lattice (R. Swinbank and R. J. Purser, Q. J. R. Meteorol. Soc. 132, 2006),
    which turns by the golden angle from each point to the next, and the other half mirrored.
    """
    half = np.arange(count // 2)
    z = (2.0 * half + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * half
    ring = np.sqrt(1.0 - z * z)
    upper = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), z])
    return np.vstack([upper, -upper])


def _scaled_arms(contacts: ContactArrays) -> np.ndarray:
    """Arms from the contacts' mean over their mean length (n, 3)."""
    arms = contacts.positions - contacts.positions.mean(axis=0)
    return arms / (np.linalg.norm(arms, axis=1).mean() + LEAST_ARM)
