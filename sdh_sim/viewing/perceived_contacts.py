"""The perceived contacts in a recording: g*, friction cones, and the forces for the weight.

All entities are below the object, in its frame, at the time of the snapshot.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
import trimesh

import graspq as gq
from graspq.contact import tangent_basis
from sdh_sim.metrics import hand_bound
from sdh_sim.metrics.built_in import EDGES
from sdh_sim.sensing import PadContact, PerceivedGrasp
from sdh_sim.viewing.style import LIMIT_SCALE
from sdh_sim.viewing.wrench_space import weight_of

CONTACT_ENTITIES = ("friction_cones", "predicted_contacts", "least_effort_forces")
CONE_HEIGHT = 0.02  # [m]
CONE_COLOR = (30, 110, 255, 90)
CONTACT_COLOR, LEAST_COLOR = (30, 110, 255), (240, 190, 30)
ARROW_RADIUS = 0.0012  # [m]


def least_effort_forces(grasp: PerceivedGrasp) -> gq.ContactForces | None:
    """The contact forces of least effort that bear the weight within friction and motor torques.

    The hand would choose them if it controlled its contact forces; its motors squeeze with all
    their torque instead. The weight acts at the centre of mass as known.

    Returns:
        forces in object axes [N]; None where there is no contact or no such forces exist.
    """
    if not grasp.contacts:
        return None
    wrench = np.concatenate((weight_of(grasp), np.zeros(3)))
    try:
        return gq.contact_forces(hand_bound(grasp, held=False), wrench, edges=EDGES)
    except gq.GraspError:
        return None


def log_contacts(
    stream: rr.RecordingStream,
    path: str,
    contacts: tuple[PadContact, ...],
    least: gq.ContactForces | None,
    com: np.ndarray,
) -> None:
    """Log the contacts at the stream's time.

    Args:
        stream: to log to.
        path: entity of the object's body.
        contacts: in the object's axes about its centre of mass, at least one.
        least: what ``least_effort_forces`` gave.
        com: centre of mass in the object's frame (3,) [m].
    """
    points = np.array([pad.contact.position for pad in contacts]) + com
    limits = np.array([pad.contact.max_normal_force for pad in contacts])
    normals = np.array([pad.contact.normal for pad in contacts])
    labels = [f"{pad.pad} g* {g:.1f} N" for pad, g in zip(contacts, limits, strict=True)]
    stream.log(f"{path}/friction_cones", cones(contacts, com))
    stream.log(
        f"{path}/predicted_contacts",
        _arrows(points, limits[:, None] * normals, CONTACT_COLOR, labels),
    )
    if least is not None:
        forces = least.wrenches[:, :3]
        sizes = np.linalg.norm(forces, axis=1)
        labels = [f"{pad.pad} {size:.1f} N" for pad, size in zip(contacts, sizes, strict=True)]
        stream.log(f"{path}/least_effort_forces", _arrows(points, forces, LEAST_COLOR, labels))


def _arrows(
    points: np.ndarray, forces: np.ndarray, color: tuple[int, int, int], labels: list[str]
) -> rr.Arrows3D:
    """Forces (n, 3) [N] as arrows that end at the contact points (n, 3) [m]."""
    vectors = LIMIT_SCALE * forces
    return rr.Arrows3D(
        origins=points - vectors, vectors=vectors, colors=color, radii=ARROW_RADIUS,
        labels=labels, show_labels=False,
    )  # fmt: skip


def cones(contacts: tuple[PadContact, ...], com: np.ndarray) -> rr.Mesh3D:
    """Friction cones (equation 1) as the metrics sample them, opening into the object.

    Args:
        contacts: in the object's axes about its centre of mass.
        com: centre of mass in the object's frame (3,) [m].
    """
    corners, faces = [], []
    angles = 2 * np.pi * np.arange(EDGES) / EDGES
    for index, pad in enumerate(contacts):
        contact = pad.contact
        first, second = tangent_basis(contact.normal)
        ring = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)
        edges = contact.normal + contact.friction * ring
        corners.append(np.vstack((np.zeros(3), CONE_HEIGHT * edges)) + contact.position + com)
        start = index * (EDGES + 1)
        around = np.arange(EDGES)
        faces.append(np.stack((
            np.full(EDGES, start), start + 1 + around, start + 1 + (around + 1) % EDGES
        ), axis=1))  # fmt: skip
    vertices, triangles = np.vstack(corners), np.vstack(faces)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    return rr.Mesh3D(
        vertex_positions=vertices, triangle_indices=triangles, albedo_factor=CONE_COLOR,
        vertex_normals=mesh.vertex_normals,
    )  # fmt: skip
