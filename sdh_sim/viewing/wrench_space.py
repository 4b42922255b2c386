"""What the metrics see, in a recording: friction cones at the contacts, and the wrench space.

The wrench space is drawn as forces [N] in the object's axes: those that the contacts can exert
about the centre of mass without a moment, L1 inside L∞, and the weight they must exert.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
import trimesh

import graspq as gq
from graspq.contact import tangent_basis
from sdh_sim.metrics.built_in import EDGES, wrench_sets
from sdh_sim.metrics.prediction import Prediction
from sdh_sim.sensing.pad_contacts import PadContact
from sdh_sim.sensing.perceived_grasp import PerceivedGrasp

WRENCH_SPACE = "wrench_space"
CONE_HEIGHT = 0.02  # [m]
CONE_COLOR = (30, 110, 255, 90)
# Colours of the figures: L∞ blue, L1 orange; the outer one is seen through.
SPACE_COLORS = {"linf": (0, 114, 178, 45), "l1": (213, 94, 0, 100)}
TASK_COLOR, REACH_COLOR = (230, 40, 60), (90, 90, 90)
# Of a slice drawn to be looked at, relative; an exact one takes seconds.
SLICE_TOLERANCE = 0.02


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


def log_wrench_space(stream: rr.RecordingStream, prediction: Prediction) -> None:
    """Log both wrench spaces, the weight, and how far q* scales it."""
    grasp = prediction.grasp
    sets = wrench_sets(grasp)
    kinds = []
    for bound, color in SPACE_COLORS.items():
        kind, mesh = _forces(sets, bound)
        kinds.append(kind)
        if mesh is not None:
            shape = rr.Mesh3D(
                vertex_positions=mesh.vertices, triangle_indices=mesh.faces,
                vertex_normals=mesh.vertex_normals, albedo_factor=color,
            )  # fmt: skip
            stream.log(f"{WRENCH_SPACE}/{bound}", shape)
    weight = _weight(grasp)
    stream.log(f"{WRENCH_SPACE}/task", _arrow(weight, TASK_COLOR, "weight"))
    for bound in SPACE_COLORS:
        q = prediction.values[f"q_{bound}"]
        if np.isfinite(q) and q > 0.0:
            path = f"{WRENCH_SPACE}/reach_{bound}"
            stream.log(path, _arrow(q * weight, REACH_COLOR, f"q* {bound} {q:.2f}"))
    words = " and ".join(sorted(set(kinds)))
    stream.log(f"{WRENCH_SPACE}/what", rr.TextDocument(f"forces [N] in object axes: {words}"))


def _forces(sets: list[np.ndarray], bound: str) -> tuple[str, trimesh.Trimesh | None]:
    """What is drawn of a space, and its mesh."""
    space = gq.WrenchSpace(sets, bound)
    try:
        return "at zero moment", space.slice("force", SLICE_TOLERANCE)
    except gq.GraspError:  # no force closure, so the slice is flat or open
        pass
    try:
        return "whatever the moment", space.projection("force")
    except gq.GraspError:
        return "flat, not drawn", None


def _weight(grasp: PerceivedGrasp) -> np.ndarray:
    """The force that bears the object (3,) [N]: all wrenches of the task share it."""
    return grasp.task[:3].mean(axis=1)


def _arrow(vector: np.ndarray, color: tuple[int, int, int], label: str) -> rr.Arrows3D:
    return rr.Arrows3D(
        origins=[np.zeros(3)], vectors=[vector], colors=color, labels=[label],
        radii=0.03 * max(1.0, float(np.linalg.norm(vector))), show_labels=False,
    )  # fmt: skip
