"""The visible shapes of a scene in a recording, logged once, each below its body."""

from __future__ import annotations

import mujoco
import numpy as np
import rerun as rr

from sdh_sim.cell import Scene

SHOWN_GROUPS = (0, 1, 2)  # MuJoCo's convention: collision shapes are in 3, taxels in 4
OBJECT_ALPHA = 0.35  # transparent, so that arrows and pads behind the object show


def body_path(model: mujoco.MjModel, body: int) -> str:
    """Entity of a body, whose frame its shapes are in."""
    return f"world/{model.body(body).name}"


def log_geometry(stream: rr.RecordingStream, scene: Scene) -> None:
    """Log meshes and boxes that MuJoCo would draw, static, in their bodies' frames."""
    model = scene.model
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for geom in range(model.ngeom):
        if model.geom_group[geom] not in SHOWN_GROUPS:
            continue
        color = geom_color(model, geom)
        if model.geom_bodyid[geom] == scene.object_body:
            color[3] = OBJECT_ALPHA
        kind = model.geom_type[geom]
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            shape = mesh_shape(model, model.geom_dataid[geom], color)
        elif kind == mujoco.mjtGeom.mjGEOM_BOX:
            shape = rr.Boxes3D(half_sizes=model.geom_size[geom], colors=color, fill_mode="solid")
        else:
            continue  # the floor: the view draws a grid there
        name = model.geom(geom).name.rpartition("/")[2] or f"shape{geom}"
        path = f"{body_path(model, model.geom_bodyid[geom])}/{name}"
        w, x, y, z = model.geom_quat[geom]
        pose = rr.Transform3D(
            translation=model.geom_pos[geom], quaternion=rr.Quaternion(xyzw=[x, y, z, w])
        )
        stream.log(path, pose, shape, static=True)


def geom_color(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Red, green, blue, opacity of a geom (4,), 0 to 1: its material's, else its own."""
    material = model.geom_matid[geom]
    return np.array(model.geom_rgba[geom] if material < 0 else model.mat_rgba[material])


def mesh_shape(model: mujoco.MjModel, mesh: int, color: np.ndarray) -> rr.Mesh3D:
    """A compiled mesh with its normals, in the frame that its geom's pose places."""
    rows = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    # MuJoCo indexes vertices and normals apart, rerun together: one vertex per pair.
    corners = np.stack((model.mesh_face[rows], model.mesh_facenormal[rows]), axis=-1)
    pairs, faces = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    return rr.Mesh3D(
        vertex_positions=model.mesh_vert[model.mesh_vertadr[mesh] + pairs[:, 0]],
        vertex_normals=model.mesh_normal[model.mesh_normaladr[mesh] + pairs[:, 1]],
        triangle_indices=faces.reshape(-1, 3),
        albedo_factor=color,
    )
