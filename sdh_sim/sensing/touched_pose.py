"""The tracked pose of an object, corrected by what the hand feels.

A tracker is millimetres off; a pad that reads a force touches the object, one that reads nothing
does not, no part of the hand is inside it, and on the table its lowest point is at the table's
height. The pose that fits all of that best, near the tracked one, is found by Gauss-Newton steps on
robust residuals [Hartley and Zisserman: Multiple View Geometry, 2004, appendix 6]; distances and
their derivatives come from MuJoCo's collision of the hand, its taxels included, with the object.
"""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np

from sdh_sim import poses
from sdh_sim.objects import ObjectInfo, object_spec
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.poses import rotation_of
from sdh_sim.robot import Hand, HandKinematics, taxel_names
from sdh_sim.sensing.hand_with_object import HandWithObject
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.user_references import ObjectFolder

# Taxels that read less than this share of their pad's largest reading may touch nothing: the
# arrays' crosstalk lights neighbours.
LOADED = 0.35
REACH = 0.02  # surfaces further apart are not looked at [m]
MEMORY = 1 << 26  # for the many contacts within reach [byte]
# Standard deviation of where a loaded taxel's surface lies, and of the table [m]. The pad's rubber
# gives by less than half of it.
FEELS, STANDS = 1e-3, 1e-3
FOOT = 1e-3  # points of the object that are so little above its lowest stand on the table too [m]
# Residuals, in standard deviations, beyond which one counts less and less (Cauchy's weight).
ROBUST = 2.0
STEPS, SMALL = 15, 1e-6  # Gauss-Newton steps at most, and one [m, rad] that ends them


def touched_pose(
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    position_error: float,
    angle_error: float,
    kinematics: HandKinematics,
    on_table: bool,
) -> np.ndarray:
    """The pose of the object in the palm frame that the hand's touch makes most likely (7,).

    Args:
        snapshot: what the hand sensed, with the tracked pose.
        obj: the object.
        position_error: standard deviation of the tracked position along each axis [m], above 0.
        angle_error: of its rotation about each axis [rad], above 0.
        kinematics: the hand.
        on_table: whether the object stands on the table or above it; False where there is none.
    """
    joints = snapshot.joints
    if joints is None:
        joints = kinematics.joint_positions(snapshot.joint_angles)
    shapes = _shapes(kinematics.hand, obj.name, obj.folder)
    shapes.pose_hand(joints)
    loaded = _loaded(snapshot, kinematics.hand)
    deviations = np.repeat((position_error, angle_error), 3)
    tracked, pose = snapshot.object_pose_hand, snapshot.object_pose_hand.copy()
    moved = np.zeros(6)
    for _ in range(STEPS):
        rows, residuals, weights = shapes.residuals(pose, obj.com_m, loaded)
        if on_table:
            row, residual = _table(snapshot.hand_pose_world, pose, obj, shapes.vertices)
            rows = np.vstack((rows, row))
            residuals, weights = np.append(residuals, residual), np.append(weights, 1.0)
        weights = weights / (1.0 + (residuals / ROBUST) ** 2)
        normal = (rows.T * weights) @ rows + np.diag(deviations**-2)
        step = -np.linalg.solve(normal, (rows.T * weights) @ residuals + moved / deviations**2)
        moved = moved + step
        pose = _moved(tracked, moved, obj.com_m)
        if np.abs(step).max() < SMALL:
            break
    return pose


def _moved(pose: np.ndarray, motion: np.ndarray, com: np.ndarray) -> np.ndarray:
    """A pose after a motion (6,) of the centre of mass and about it, in the palm's axes."""
    centre = poses.transform(pose, com)
    turn = np.zeros(4)
    turn[0] = 1.0
    angle = float(np.linalg.norm(motion[3:]))
    if angle > 0.0:
        mujoco.mju_axisAngle2Quat(turn, motion[3:] / angle, angle)
    quat = poses.product(turn, pose[3:])
    return np.concatenate((centre + motion[:3] - rotation_of(quat) @ com, quat))


def _loaded(snapshot: TactileSnapshot, hand: Hand) -> dict[str, float]:
    """Weight of every taxel that surely touches, by name: those of a pad weigh one together."""
    readings = {kind: iter(arrays) for kind, arrays in snapshot.tactile.items()}
    found = {}
    for pad, names in zip(hand.pads, taxel_names(hand), strict=True):
        reading = np.where(pad.array.live, next(readings[pad.array.kind]), 0.0).ravel()
        sure = np.flatnonzero((reading > 0.0) & (reading >= LOADED * reading.max()))
        found |= {names[k]: 1.0 / len(sure) for k in sure}
    return found


def _table(
    hand_pose: np.ndarray, pose: np.ndarray, obj: ObjectInfo, vertices: np.ndarray
) -> tuple[np.ndarray, float]:
    """Derivative (6,) and residual of the height of the object's foot over the table."""
    up = rotation_of(hand_pose[3:])[2]  # the world's z in the palm's axes
    turned = vertices @ rotation_of(pose[3:]).T
    heights = turned @ up
    # A flat foot has several lowest points: which of them is lowest must not tilt it.
    foot = turned[heights < heights.min() + FOOT].mean(axis=0) + pose[:3]
    height = float(hand_pose[2] + up @ foot)
    arm = foot - poses.transform(pose, obj.com_m)
    return np.concatenate((up, np.cross(arm, up))) / STANDS, height / STANDS


class _Shapes(HandWithObject):
    """Collision shapes, of which those of the hand meet the object alone."""

    def __init__(self, hand: Hand, name: str, folder: ObjectFolder | None) -> None:
        super().__init__(hand, object_spec(name, folder), REACH, MEMORY)
        model, of_object = self.model, self.of_object
        collides = (model.geom_contype | model.geom_conaffinity) != 0
        model.geom_contype[:] = collides & of_object
        model.geom_conaffinity[:] = collides & ~of_object
        self._names = [model.geom(k).name for k in range(model.ngeom)]
        self.vertices = collision_vertices(object_spec(name, folder).compile())

    def residuals(
        self, pose: np.ndarray, com: np.ndarray, loaded: dict[str, float]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives (k, 6), residuals (k,) in standard deviations and weights (k,) of touch.

        Loaded taxels lie on the object's surface; of all other parts only those that are inside
        the object say something, those of a link together as much as one.
        """
        self.collide(pose)
        contact = self.data.contact
        first_is_object = self.of_object[contact.geom[:, 0]]
        geom = np.where(first_is_object, contact.geom[:, 1], contact.geom[:, 0])
        # An object of several parts is as near as its nearest.
        order = np.lexsort((contact.dist, geom))
        _, nearest = np.unique(geom[order], return_index=True)
        chosen = order[nearest]
        geom, distance = geom[chosen], contact.dist[chosen]
        weights = np.array([loaded.get(self._names[k], 0.0) for k in geom])
        inside = (weights == 0.0) & (distance < 0.0)
        for link in np.unique(self.model.geom_bodyid[geom[inside]]):
            of_link = inside & (self.model.geom_bodyid[geom] == link)
            weights[of_link] = 1.0 / of_link.sum()
        used = weights > 0.0
        axes, origin = self.palm_axes, self.palm_pose[:3]
        # The first axis of a contact points from the first geom to the second.
        sign = np.where(first_is_object[chosen[used]], -1.0, 1.0)[:, None]
        normals = sign * contact.frame[chosen[used], :3] @ axes
        arms = (contact.pos[chosen[used]] - origin) @ axes - poses.transform(pose, com)
        rows = np.hstack((normals, np.cross(arms, normals))) / FEELS
        return rows, distance[used] / FEELS, weights[used]


@lru_cache(maxsize=16)
def _shapes(hand: Hand, name: str, folder: ObjectFolder | None) -> _Shapes:
    return _Shapes(hand, name, folder)
