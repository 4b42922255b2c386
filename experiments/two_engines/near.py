"""Only taxels near the object collide: a pad's overlapping spheres cost nearly all of the time.

Every taxel has its geometry in Drake, without a role in contact until the object comes near.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import mujoco
import numpy as np
from pydrake.geometry import CollisionFilterDeclaration, GeometrySet, RoleAssign
from pydrake.systems.framework import Context

from experiments.two_engines.contact_laws import touchable
from experiments.two_engines.translate import DrakeScene
from sdh_sim.cell import Scene

NEAR = 4e-3  # gap to the object below which a taxel takes part [m]
MOVED = 2e-3  # motion of a taxel against the object after which gaps are looked at again [m]


class NearTaxels:
    """Gives taxels their role in contact as the object comes near; they keep it.

    Args:
        made: the translated scene.
        graph_context: of its scene graph, that is to be changed.
        plant_context: with the positions.
    """

    def __init__(self, made: DrakeScene, graph_context: Context, plant_context: Context) -> None:
        self._made, self._graph_context, self._context = made, graph_context, plant_context
        self._idle = dict(made.surfaces.idle)
        self._mirror = mujoco.MjData(made.scene.model)
        self._before: np.ndarray | None = None

    @property
    def idle(self) -> int:
        """How many taxels have no role in contact yet."""
        return len(self._idle)

    def update(self) -> None:
        """Look whether taxels have come near, where they can have since the last time."""
        if not self._idle:
            return
        now = self._positions()
        if self._before is not None and np.abs(now - self._before).max() < MOVED / np.sqrt(3.0):
            return
        self._before = now
        near = [found for found, geom in self._idle.items() if self._gap(geom) < NEAR]
        if not near:
            return
        made, surfaces = self._made, self._made.surfaces
        source = made.plant.get_source_id()
        assert source is not None
        for found in near:
            made.graph.AssignRole(
                self._graph_context, source, found, surfaces.materials[found], RoleAssign.kNew
            )
            del self._idle[found]
        active = [g for g in surfaces.geom if g not in self._idle and g not in near]
        strange = [*active, *surfaces.table]
        if surfaces.standing is not surfaces.obj:
            strange += surfaces.standing
        declared = CollisionFilterDeclaration()
        declared.ExcludeBetween(GeometrySet(near), GeometrySet(strange))
        declared.ExcludeWithin(GeometrySet(near))
        made.graph.collision_filter_manager(self._graph_context).Apply(declared)

    def _positions(self) -> np.ndarray:
        """Centres of the taxels in the object's frame (n, 3) [m]; MuJoCo's data follow."""
        put(self._made, self._context, self._mirror)
        scene, data = self._made.scene, self._mirror
        axes = data.xmat[scene.object_body].reshape(3, 3)
        return (data.geom_xpos[scene.taxel >= 0] - data.xpos[scene.object_body]) @ axes

    def _gap(self, geom: int) -> float:
        scene = self._made.scene
        own = np.flatnonzero(touchable(scene.model, scene.object_body))
        gaps = (
            mujoco.mj_geomDistance(scene.model, self._mirror, geom, int(other), 2 * NEAR, None)
            for other in own
        )
        return min(gaps)


def put(made: DrakeScene, context: Context, data: mujoco.MjData) -> None:
    """Bring MuJoCo's kinematics to where Drake has hand and object, in the palm's frame.

    The arm stays where it is in ``data``: poses of hand and object are right against each other.
    """
    scene, plant = made.scene, made.plant
    positions = plant.GetPositions(context)
    for number, joint in (made.joints | (made.object_joints or {})).items():
        data.qpos[scene.model.jnt_qposadr[number]] = positions[joint.position_start()]
    mujoco.mj_kinematics(scene.model, data)
    if made.object_joints is not None:
        return
    found = plant.CalcRelativeTransform(context, made.palm.body_frame(), made.obj.body_frame())
    at = slice(scene.object_qpos, scene.object_qpos + 7)
    data.qpos[at] = in_world(scene, data, found.translation(), found.rotation().matrix())
    mujoco.mj_kinematics(scene.model, data)


def in_world(
    scene: Scene, data: mujoco.MjData, position: np.ndarray, rotation: np.ndarray
) -> np.ndarray:
    """Pose in the world (7,) of what is at a position (3,) and rotation (3, 3) in the palm."""
    axes = data.xmat[scene.palm].reshape(3, 3)
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, (axes @ rotation).ravel())
    return np.concatenate((data.xpos[scene.palm] + axes @ position, quat))
