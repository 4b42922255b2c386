"""One grasp before anything moves: where the hand goes, and how its fingers close."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim import poses
from sdh_sim.errors import SettingsError
from sdh_sim.objects import ObjectInfo
from sdh_sim.robot import Closing

if TYPE_CHECKING:
    from sdh_sim.grasping.grasp_sampler import RandomGrasp

OBJECT_POSITION = (0.56, 0.0)  # where the object stands on the table [m]
UNIT_WITHIN = 1e-6  # by which the length of a quaternion may differ from 1
ROUND_OFF = 1e-15  # by which it may without being made 1 anew, which would change its last bits


@dataclass(frozen=True, eq=False)
class GraspPlan:
    """One grasp before anything moves, in the world.

    Attributes:
        palm_position: of the palm frame when the fingers close (3,) [m].
        palm_rotation: its axes as columns (3, 3).
        object_yaw: of the object about the vertical, from where it stands by itself [rad].
        closing: how the fingers close.
        opening: closing ratio during the approach; None: the most closed one that touches nothing.
        turnable: hand and object may be turned together about the vertical, to suit the arm.
        name: in tables; empty for a random grasp.
        drawn: how a random grasp came about; None for any other.
        given_pose: of the palm in the object's frame, where that is what the plan was made from.
    """

    palm_position: np.ndarray
    palm_rotation: np.ndarray
    object_yaw: float
    closing: Closing
    opening: float | None = None
    turnable: bool = False
    name: str = ""
    drawn: RandomGrasp | None = None
    given_pose: np.ndarray | None = None

    @classmethod
    def from_pose(
        cls,
        obj: ObjectInfo,
        palm_pose: Sequence[float] | np.ndarray,
        closing: Closing,
        *,
        opening: float | None = None,
        object_yaw: float | None = None,
        name: str = "",
    ) -> GraspPlan:
        """A grasp given in the frame of the object.

        Args:
            obj: the object.
            palm_pose: of the palm frame in the object's frame, x y z qw qx qy qz (7,) [m].
            closing: how the fingers close, such as ``closing_between(open, closed)``.
            opening: as above.
            object_yaw: as above; None leaves it free.
            name: as above.

        Raises:
            SettingsError: a pose that is none, a ratio beyond 0 to 1, or a yaw that is not finite.
        """
        try:
            pose = np.array(palm_pose, dtype=float)
        except (TypeError, ValueError):
            pose = np.zeros(0)
        if pose.shape != (7,) or not np.isfinite(pose).all():
            raise SettingsError(
                f"palm_pose: got {palm_pose!r:.120}; give x y z in m and a unit quaternion w x y z"
            )
        length = float(np.linalg.norm(pose[3:]))
        if abs(length - 1.0) > UNIT_WITHIN:
            raise SettingsError(
                f"palm_pose: its quaternion has the length {length:.9g}; give a unit one, w x y z"
            )
        if opening is not None and not 0.0 <= opening <= 1.0:
            raise SettingsError(f"opening: got {opening!r}; allowed is 0 (open) to 1 (closed)")
        yaw = 0.0 if object_yaw is None else float(object_yaw)
        if not math.isfinite(yaw):
            raise SettingsError(f"object_yaw: got {object_yaw!r}; give an angle in rad")
        if abs(length - 1.0) > ROUND_OFF:
            pose[3:] /= length
        palm = poses.compose(standing_pose(obj, yaw), pose)
        return cls(
            palm[:3],
            poses.rotation_of(palm[3:]),
            yaw,
            closing,
            opening,
            turnable=object_yaw is None,
            name=name,
            given_pose=pose,
        )

    def palm_in_object(self, obj: ObjectInfo) -> np.ndarray:
        """Pose of the palm in the object's frame, x y z qw qx qy qz (7,) [m]."""
        if self.given_pose is not None:
            return self.given_pose.copy()
        palm = np.concatenate((self.palm_position, poses.quaternion_of(self.palm_rotation)))
        return poses.relative(standing_pose(obj, self.object_yaw), palm)

    def turned(self, angle: float) -> GraspPlan:
        """Hand and object turned together about the vertical through the object's place [rad]."""
        turn = poses.rotation_of(poses.about_z(angle))
        place = np.array([*OBJECT_POSITION, 0.0])
        return replace(
            self,
            palm_position=place + turn @ (self.palm_position - place),
            palm_rotation=turn @ self.palm_rotation,
            object_yaw=math.remainder(self.object_yaw + angle, 2 * math.pi),
        )

    def moved(self, offset: np.ndarray, roll: float) -> GraspPlan:
        """The hand elsewhere.

        Args:
            offset: along the palm's axes (3,) [m].
            roll: about the palm's z [rad].
        """
        turn = poses.rotation_of(poses.about_z(roll))
        return replace(
            self,
            palm_position=self.palm_position + self.palm_rotation @ offset,
            palm_rotation=self.palm_rotation @ turn,
            given_pose=None,
        )

    def as_given(self, obj: ObjectInfo) -> GraspPlan:
        """The grasp made anew from its pose in the object's frame and the object's yaw.

        Tables and files keep these two. A trial of the plan from here is repeated by them to the
        last bit, which would grow: contact forces are sensitive.
        """
        pose = self.palm_in_object(obj)
        same = GraspPlan.from_pose(obj, pose, self.closing, object_yaw=self.object_yaw)
        return replace(
            self,
            palm_position=same.palm_position,
            palm_rotation=same.palm_rotation,
            given_pose=same.given_pose,
        )


def standing_pose(obj: ObjectInfo, yaw: float) -> np.ndarray:
    """Pose in the world of an object that stands at its place, turned by a yaw [rad] (7,)."""
    turn = poses.product(poses.about_z(yaw), obj.standing_quat)
    return np.concatenate(((*OBJECT_POSITION, obj.standing_height), turn))
