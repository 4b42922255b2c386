"""A contact and the set of wrenches it can exert (equations 1 to 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graspq.ellipsoid import EllipsoidSet
from graspq.errors import GraspError, as_array, as_choice, as_number, as_unit

AUGMENTATIONS = ("none", "fl", "hf", "sf")


@dataclass(frozen=True, eq=False, init=False)
class Contact:
    """One contact of a grasp.

    Attributes:
        position: pressure-weighted centre of the contact, shape (3,) [m].
        normal: unit normal pointing into the object, shape (3,).
        friction: Coulomb friction coefficient μ >= 0.
        max_normal_force: largest normal force g* [N], equation 6.
        max_torsion: largest frictional moment about the normal τ* [N m], equation 7;
            0 is a hard finger.
        patch: centres of the taxels in contact, shape (k, 3) [m], or None for a point.
    """

    position: np.ndarray
    normal: np.ndarray
    friction: float
    max_normal_force: float
    max_torsion: float
    patch: np.ndarray | None

    def __init__(
        self,
        position: ArrayLike,
        normal: ArrayLike,
        friction: float,
        max_normal_force: float = 1.0,
        max_torsion: float = 0.0,
        patch: ArrayLike | None = None,
    ) -> None:
        taxels = None
        if patch is not None:
            taxels = as_array("patch", patch, (None, 3), "give None for a point contact")
            if len(taxels) == 0:
                raise GraspError(
                    "patch: got no taxel, expected shape (k, 3) with k >= 1;"
                    " give None for a point contact"
                )
        values = {
            "position": _frozen(as_array("position", position, (3,))),
            "normal": _frozen(as_unit("normal", normal)),
            "friction": as_number("friction", friction),
            "max_normal_force": as_number("max_normal_force", max_normal_force),
            "max_torsion": as_number("max_torsion", max_torsion),
            "patch": None if taxels is None else _frozen(taxels),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)


def tangent_basis(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors a, b with (a, b, normal) right-handed.

    The second column of the Householder reflection that takes ``normal`` to the x axis is a,
    and b = normal × a. It is defined for every normal and deterministic.
    """
    n = np.asarray(normal, dtype=float)
    length = float(np.sqrt(n @ n))
    if n[1] == 0.0 and n[2] == 0.0:
        a = np.array([0.0, 1.0, 0.0])
    else:
        beta = -length if n[0] >= 0.0 else length
        v = np.array([1.0, n[1] / (n[0] - beta), n[2] / (n[0] - beta)])
        tau = (beta - n[0]) / beta
        a = np.array([0.0, 1.0, 0.0]) - tau * v[1] * v
    return a, np.cross(n / length, a)


def contact_wrenches(
    contact: Contact,
    edges: int | None = 12,
    augment: str = "none",
    *,
    torque_scale: float = 1.0,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> Any:
    """Return the vertices of a contact's wrench set at full normal force, shape (6, l).

    Every column is (force [N], moment [N m]) in the frame of the contact, the moment about
    ``origin`` and multiplied by ``torque_scale``. The friction ellipsoid of equation 1 is
    sampled by ``edges`` points on its circular base (``f_z = g*``, tangential force ``μ g*``)
    and, when ``τ* > 0``, its two torsion apices (``f_z = g*``, ``τ_z = ±τ*``), which come last.
    The columns of the centre come first, then those of each taxel in turn.

    Args:
        contact: the contact.
        edges: number of points on the base, at least 3; None keeps the ellipsoid itself and
            returns an ``EllipsoidSet``.
        augment: what acts at every taxel of ``contact.patch`` beside the centre's own set
            (equation 2): "none" nothing, "fl" a frictionless normal force, "hf" a hard-finger
            cone, "sf" the soft finger of the centre.
        torque_scale: factor on every moment; 1 puts N m beside N.
        origin: point that moments are taken about, shape (3,) [m].

    Raises:
        GraspError: for an unknown ``augment``, too few ``edges``, or ``augment`` other than
            "none" on a contact without a patch.
    """
    augment = as_choice("augment", augment, AUGMENTATIONS)
    if edges is not None and (
        isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3
    ):
        raise GraspError(f"edges: expected an integer >= 3 or None, got {edges!r}")
    scale = as_number("torque_scale", torque_scale, positive=True)
    about = as_array("origin", origin, (3,))
    if augment != "none" and contact.patch is None:
        raise GraspError(
            f"augment: {augment!r} needs the taxels of the contact, but its"
            " patch is None; give a patch or augment='none'"
        )
    taxels = contact.patch if augment != "none" and contact.patch is not None else np.empty((0, 3))
    if edges is None:
        return _ellipsoids(contact, taxels, augment, scale, about)
    force, spin = _friction_samples(contact, int(edges), soft=contact.max_torsion > 0)
    wrenches = _wrenches(contact.position[None] - about, force, spin)
    if augment == "fl":
        force, spin = contact.max_normal_force * contact.normal[:, None], np.zeros((3, 1))
    elif augment == "hf":
        force, spin = _friction_samples(contact, int(edges), soft=False)
    if len(taxels):
        wrenches = np.hstack([wrenches, _wrenches(taxels - about, force, spin)])
    wrenches[3:] *= scale
    return wrenches


def _ellipsoids(
    contact: Contact, taxels: Any, augment: str, scale: float, about: np.ndarray
) -> EllipsoidSet:
    a, b = tangent_basis(contact.normal)
    push = contact.max_normal_force * contact.normal
    side = contact.max_normal_force * contact.friction
    force = np.column_stack([push, side * a, side * b, np.zeros(3)])
    spin = np.zeros((3, 4))
    spin[:, 3] = contact.max_torsion * contact.normal

    def at(points: np.ndarray, twist: bool) -> np.ndarray:
        wrenches = _wrenches(points - about, force, spin if twist else 0.0 * spin)
        wrenches[3:] *= scale
        return wrenches.reshape(6, len(points), 4).swapaxes(0, 1)

    stack = at(contact.position[None], True)
    loose = np.zeros((6, 0))
    if augment == "fl":
        loose = at(taxels, False)[:, :, 0].T
    elif len(taxels):
        stack = np.vstack([stack, at(taxels, augment == "sf")])
    return EllipsoidSet(stack[:, :, 0].T, stack[:, :, 1:], loose)


def _friction_samples(contact: Contact, edges: int, soft: bool) -> tuple[np.ndarray, np.ndarray]:
    """Forces and free moments of the sampled ellipsoid, each of shape (3, edges [+ 2])."""
    a, b = tangent_basis(contact.normal)
    angle = 2.0 * np.pi * np.arange(edges) / edges
    side = contact.friction * (np.outer(a, np.cos(angle)) + np.outer(b, np.sin(angle)))
    force = contact.max_normal_force * (contact.normal[:, None] + side)
    spin = np.zeros((3, edges))
    if soft:
        force = np.hstack(
            [force, np.repeat(contact.max_normal_force * contact.normal[:, None], 2, axis=1)]
        )
        spin = np.hstack([spin, contact.max_torsion * np.outer(contact.normal, [1.0, -1.0])])
    return force, spin


def _wrenches(arms: np.ndarray, force: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Wrenches (6, k l) of l forces and free moments (3, l) at each of k points (k, 3)."""
    count = len(arms)
    x, y, z = (column[:, None] for column in arms.T)
    moment = (
        np.stack(
            [y * force[2] - z * force[1], z * force[0] - x * force[2], x * force[1] - y * force[0]]
        )
        + spin[:, None]
    )
    wrenches = np.empty((6, count, force.shape[1]))
    wrenches[:3], wrenches[3:] = force[:, None], moment
    return wrenches.reshape(6, -1)


def _frozen(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array
