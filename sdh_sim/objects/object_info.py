"""What is known of an object before any simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdh_sim.objects.facts import Spread
from sdh_sim.user_references import ObjectFolder

__all__ = ["OBJECT", "ObjectInfo", "Spread"]

OBJECT = "object/"  # prefix of its names in a model with others


@dataclass(frozen=True)
class ObjectInfo:
    """What is known of an object before any simulation.

    Attributes:
        name: folder name of the model.
        mass_kg: mass [kg].
        friction: coefficient of Coulomb friction against the pads.
        com_m: centre of mass in the object's frame (3,) [m].
        extents_m: size along the axes of the object's frame (3,) [m].
        standing_quat: orientation in which it stands on the table, w x y z (4,).
        standing_height: height of the object's frame over the table when standing [m].
        height: height of its top over the table when standing [m].
        narrow_yaw: direction of its narrower horizontal side when standing at yaw 0 [rad].
        half_narrow: half of the narrower horizontal side [m].
        half_wide: half of the wider horizontal side [m].
        inertia_kgm2: inertia tensor at the centre of mass, object axes (3, 3) [kg m^2].
        spread: of the random grasps on it; None: what ``grasp_sampler`` has for its name, or the
            default.
        folder: where a user's object comes from; None for a built-in one.
    """

    name: str
    mass_kg: float
    friction: float
    com_m: np.ndarray
    extents_m: np.ndarray
    standing_quat: np.ndarray
    standing_height: float
    height: float
    narrow_yaw: float
    half_narrow: float
    half_wide: float
    inertia_kgm2: np.ndarray
    spread: Spread | None = None
    folder: ObjectFolder | None = None
