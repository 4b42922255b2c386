"""MuJoCo's contacts as springs and dampers, which is what another engine takes."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from experiments.two_engines.alignment import DISSIPATION, HARD, Alignment
from sdh_sim.cell import Scene


class ContactLaw(NamedTuple):
    """What a contact of a geom with the object bears, penetrated by r at speed v: k (r + T v).

    Attributes:
        stiffness: k [N/m].
        relaxation: T [s], by which the force runs ahead of the penetration.
        friction: coefficient.
    """

    stiffness: float
    relaxation: float
    friction: float


def law_at_rest(model: mujoco.MjModel, geom: int, other: int) -> ContactLaw:
    """The contact of two geoms of a compiled model, linearised where it begins.

    With impedance d and A the sum of both bodies' ``invweight0`` MuJoCo's regularised constraint
    bears K d² r / ((1 - d) A) at rest, and B d v / ((1 - d) A) more while it is approached
    with v; K and B come from ``solref``, d from ``solimp`` at r = 0.

    Args:
        model: compiled.
        geom, other: ids; the parameters are those of the one with the higher priority, of the
            first where both have the same.
    """
    ahead = model.geom_priority[other] > model.geom_priority[geom]
    ruling = other if ahead else geom
    first, second = model.geom_solref[ruling]
    d, largest = model.geom_solimp[ruling, :2]
    if first > 0.0:  # time constant and damping ratio
        k, b = 1.0 / (largest * first * second) ** 2, 2.0 / (largest * first)
    else:  # stiffness and damping
        k, b = -first / largest**2, -second / largest
    a = sum(model.body_invweight0[model.geom_bodyid[g], 0] for g in (geom, other))
    if not a:  # neither can move, so that they never bear on each other
        return ContactLaw(HARD, 0.0, 0.0)
    friction = model.geom_friction[ruling, 0]
    if model.geom_priority[geom] == model.geom_priority[other]:
        friction = max(model.geom_friction[geom, 0], model.geom_friction[other, 0])
    return ContactLaw(
        stiffness=float(k * d**2 / ((1.0 - d) * a)),
        relaxation=float(b / (k * d)),
        friction=float(friction),
    )


def law_of(scene: Scene, geom: int, alignment: Alignment) -> ContactLaw:
    """The contact of a geom of hand or table with the object, as far as it is to be aligned."""
    model = scene.model
    of_object = int(np.flatnonzero(touchable(model, scene.object_body))[0])
    law = law_at_rest(model, geom, of_object)
    if geom == scene.table:
        if not alignment.table:
            law = law._replace(stiffness=HARD, friction=object_friction(scene))
    elif scene.taxel[geom] < 0 and not alignment.hard:
        law = law._replace(stiffness=HARD)
    return law


def object_friction(scene: Scene) -> float:
    """Coefficient of the object's surface in the compiled model."""
    own = np.flatnonzero(touchable(scene.model, scene.object_body))
    return float(scene.model.geom_friction[own[0], 0])


def touchable(model: mujoco.MjModel, body: int) -> np.ndarray:
    """Which geoms belong to a body and collide at all (ngeom,) bool."""
    collides = (model.geom_contype > 0) | (model.geom_conaffinity > 0)
    return collides & (model.geom_bodyid == body)


def hunt_crossley(alignment: Alignment) -> float:
    """Dissipation of contacts that is in proportion to their force [s/m]."""
    return 0.0 if alignment.dissipation else DISSIPATION
