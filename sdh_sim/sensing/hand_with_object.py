"""A hand and an object alone, as the tracker and the joint angles place them: what collides."""

from __future__ import annotations

import mujoco
import numpy as np

from sdh_sim import poses
from sdh_sim.objects import OBJECT
from sdh_sim.robot import Hand, hand_spec

OBJECT_BODY, FREE_JOINT = f"{OBJECT}object", f"{OBJECT}free"


def hand_with_object(hand: Hand, shape: mujoco.MjSpec) -> mujoco.MjSpec:
    """Model of a hand with its taxels, fixed at its mounting face, and of an object that is free.

    Args:
        hand: the hand.
        shape: the object's model; it becomes a part of the result.
    """
    spec = hand_spec(hand)
    spec.attach(shape, prefix=OBJECT, frame=spec.worldbody.add_frame())
    spec.body(OBJECT_BODY).add_freejoint(name=FREE_JOINT)
    return spec


class HandWithObject:
    """Collision shapes of a hand and of one object.

    Attributes:
        model, data: of MuJoCo, in the world of the hand's mounting face.
        of_object: which geoms are the object's (ngeom,) bool.
        palm_pose: of the palm, x y z qw qx qy qz (7,).
        palm_axes: its axes as columns (3, 3).
    """

    def __init__(self, hand: Hand, shape: mujoco.MjSpec, margin: float, memory: int = -1) -> None:
        """Compile them.

        Args:
            hand: the hand.
            shape: the object's model.
            margin: surfaces nearer than this are contacts [m].
            memory: for contacts [byte]; -1: as MuJoCo chooses.
        """
        spec = hand_with_object(hand, shape)
        spec.memory = memory
        self.model = model = spec.compile()
        self.data = mujoco.MjData(model)
        owners = [model.body(int(body)).name for body in model.geom_bodyid]
        self.of_object = np.array([body.startswith(OBJECT) for body in owners])
        model.geom_margin[~self.of_object] = margin
        free = int(model.joint(FREE_JOINT).qposadr[0])
        self._free, self._hand = slice(free, free + 7), slice(0, free)
        self._palm = model.body(hand.palm).id

    def pose_hand(self, joints: np.ndarray) -> None:
        """Bring the hand to positions of all its joints [rad or m]."""
        self.data.qpos[self._hand] = joints
        mujoco.mj_kinematics(self.model, self.data)
        self.palm_pose = poses.body_pose(self.data, self._palm)
        self.palm_axes = poses.rotation_of(self.palm_pose[3:])

    def collide(self, pose: np.ndarray) -> None:
        """Find the contacts with the object at a pose in the palm frame (7,)."""
        self.data.qpos[self._free] = poses.compose(self.palm_pose, pose)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
