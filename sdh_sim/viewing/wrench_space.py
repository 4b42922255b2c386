"""The wrench space of a grasp in a recording.

It is drawn as forces [N] in the object's axes: those that the contacts can exert about the centre
of mass without a moment, L1 inside L∞, and the weight that they must bear.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
import trimesh

import graspq as gq
from sdh_sim.metrics import Prediction, wrench_sets
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.viewing.style import WRENCH_SPACE

# Colours of the report's figures: L∞ blue, L1 orange; the outer one is transparent.
SPACE_COLORS = {"linf": (0, 114, 178, 45), "l1": (213, 94, 0, 100)}
TASK_COLOR, REACH_COLOR = (230, 40, 60), (90, 90, 90)
# Relative error of a slice, enough for a picture; an exact one takes seconds.
SLICE_TOLERANCE = 0.02


def log_wrench_space(stream: rr.RecordingStream, prediction: Prediction) -> None:
    """Log both wrench spaces, the weight, and the weight times q*, at the stream's time."""
    grasp = prediction.grasp
    sets = wrench_sets(grasp)
    descriptions = []
    for bound, color in SPACE_COLORS.items():
        description, mesh = _forces(sets, bound)
        descriptions.append(description)
        if mesh is not None:
            shape = rr.Mesh3D(
                vertex_positions=mesh.vertices, triangle_indices=mesh.faces,
                vertex_normals=mesh.vertex_normals, albedo_factor=color,
            )  # fmt: skip
            stream.log(f"{WRENCH_SPACE}/{bound}", shape)
    weight = weight_of(grasp)
    stream.log(f"{WRENCH_SPACE}/task", _arrow(weight, TASK_COLOR, "weight"))
    for bound in SPACE_COLORS:
        q = prediction.values[f"q_{bound}"]
        if np.isfinite(q) and q > 0.0:
            path = f"{WRENCH_SPACE}/reach_{bound}"
            stream.log(path, _arrow(q * weight, REACH_COLOR, f"q* {bound} {q:.2f}"))
    text = " and ".join(sorted(set(descriptions)))
    stream.log(f"{WRENCH_SPACE}/what", rr.TextDocument(f"forces [N] in object axes: {text}"))


def _forces(sets: list[np.ndarray], bound: str) -> tuple[str, trimesh.Trimesh | None]:
    """What is drawn of a wrench space, and its mesh; None where it is flat."""
    space = gq.WrenchSpace(sets, bound)
    try:
        return "at zero moment", space.slice("force", SLICE_TOLERANCE)
    except gq.GraspError:  # no force closure, so the slice is flat or open
        pass
    try:
        return "whatever the moment", space.projection("force")
    except gq.GraspError:
        return "flat, not drawn", None


def weight_of(grasp: PerceivedGrasp) -> np.ndarray:
    """The force that bears the object (3,) [N], object axes: all wrenches of the task share it."""
    return grasp.task[:3].mean(axis=1)


def _arrow(vector: np.ndarray, color: tuple[int, int, int], label: str) -> rr.Arrows3D:
    """A force (3,) [N] from the origin, its radius by its length."""
    return rr.Arrows3D(
        origins=[np.zeros(3)], vectors=[vector], colors=color, labels=[label],
        radii=0.03 * max(1.0, float(np.linalg.norm(vector))), show_labels=False,
    )  # fmt: skip
