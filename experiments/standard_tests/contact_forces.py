"""Contacts of hand and object with their normals, and what statics allow them to bear."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.optimize import linprog

from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import forces_on_object
from sdh_sim.robot import HAND, hand_kinematics

EDGES = 12  # of the friction cones


@dataclass(frozen=True)
class ContactForces:
    """What the hand presses with, in the palm frame.

    Attributes:
        points: (n, 3) [m].
        normals: into the object (n, 3).
        forces: on the object (n, 3) [N].
        links: bodies of the hand (n,).
        sensed: whether a taxel's rubber bears it (n,).
    """

    points: np.ndarray
    normals: np.ndarray
    forces: np.ndarray
    links: tuple[str, ...]
    sensed: np.ndarray

    @property
    def normal(self) -> np.ndarray:
        """Normal forces (n,) [N]."""
        return np.einsum("nj,nj->n", self.forces, self.normals)


def contact_forces(scene: Scene, data: mujoco.MjData) -> ContactForces:
    """All contacts between the hand and the object that bear force."""
    model, found = scene.model, forces_on_object(scene, data)
    turn = data.xmat[scene.palm].reshape(3, 3)
    bodies = model.geom_bodyid[found.geoms]
    return ContactForces(
        points=(found.points - data.xpos[scene.palm]) @ turn,
        normals=found.normals @ turn,
        forces=found.forces @ turn,
        links=tuple(model.body(int(body)).name.removeprefix(HAND) for body in bodies),
        sensed=scene.taxel[found.geoms] >= 0,
    )


def force_between_halves(found: ContactForces, centre: np.ndarray, across: np.ndarray) -> float:
    """Force [N] between the halves of a cylinder that is split along its axis.

    Args:
        found: contacts of a cylinder at rest.
        centre: a point on its axis, palm frame (3,) [m].
        across: normal of the split, palm frame (3,): the sum on this side presses against it.
    """
    side = (found.points - centre) @ across > 0.0
    return float(-(found.forces[side] @ across).sum())


def greatest_between_halves(
    scene: Scene, angles: np.ndarray, found: ContactForces, centre: np.ndarray,
    across: np.ndarray, limits: np.ndarray,
) -> float:  # fmt: skip
    """The same at most, by statics: any forces in the friction cones of these contacts.

    They balance each other, and the motors bear them: |Σ Jᵀ f| ≤ τ̄. A linear programme.

    Args:
        scene: with hand and friction.
        angles: positions of the motors (n,) [rad or m].
        found, centre, across: as above.
        limits: of the motors (n,) [N m or N].
    """
    posture = hand_kinematics(scene.hand).at(angles)
    turns = 2.0 * np.pi * np.arange(EDGES) / EDGES
    columns, gains = [], []
    for point, normal, link in zip(found.points, found.normals, found.links, strict=True):
        first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        edges = normal + scene.obj.friction * (
            np.outer(np.cos(turns), first) + np.outer(np.sin(turns), second)
        )
        jacobian = posture.of_motors(posture.jacobian(link, point))
        arms = np.cross(point - centre, edges)
        columns.append(np.hstack((edges, 10.0 * arms, edges @ jacobian)).T)
        counts = (point - centre) @ across > 0.0
        gains.append(-(edges @ across) * counts)
    if not columns:
        return 0.0
    matrix, gain = np.hstack(columns), np.concatenate(gains)
    loads = matrix[6:]
    solved = linprog(
        -gain, A_eq=matrix[:6], b_eq=np.zeros(6), A_ub=np.vstack((loads, -loads)),
        b_ub=np.tile(limits, 2), method="highs",
    )  # fmt: skip
    return float(-solved.fun) if solved.success else float("nan")
