"""Hand, object and table as one model, of which MuJoCo finds contacts and moment arms.

Its world is the hand: the face that the hand is mounted on does not move, the table does. Nothing
is integrated in time here; MuJoCo's collisions, Jacobians and transmissions are all that is used.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim import poses
from sdh_sim.objects import ObjectInfo, object_spec
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.poses import rotation_of
from sdh_sim.robot import Hand, find_transmission, hand_kinematics, moment_arms, taxel_names
from sdh_sim.sensing.hand_with_object import FREE_JOINT, OBJECT_BODY, hand_with_object
from sdh_sim.settling.increment import Springs
from sdh_sim.user_references import ObjectFolder

MARGIN = 1.5e-3  # surfaces nearer than this may touch within an increment [m]
STOP_MARGIN = 0.1  # joints and tendons nearer than this to an end stop may reach it [rad or m]
CROSSTALK = 0.1  # of a force beside a taxel, under which there is none, that it reads
HARD = 3e4  # stiffness of contacts without rubber [N/m]
STOP = 1e3  # of end stops [N m/rad or N/m]
COUPLING = 1e7  # of equalities [N m/rad or N/m]
TABLE = "settling_table"
ARM = 0.1  # length by which a turn of a joint moves a fingertip [m]
RADIUS = 0.03  # length by which a turn of the object moves its surface [m]


class Touch(NamedTuple):
    """Surfaces that touch or nearly do, found at one posture; n coordinates of hand and object.

    Attributes:
        geoms: the two geoms of each contact (c, 2).
        points: where (c, 3) [m].
        normal: unit, from the first to the second (c, 3).
        gap: distance, below 0 where they overlap (c,) [m].
        jacobian: velocity of the second less that of the first (c, 3, n).
    """

    geoms: np.ndarray
    points: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    jacobian: np.ndarray


class GraspModel:
    """A hand with its taxels, an object and the table, compiled.

    Attributes:
        model, data: of MuJoCo; positions are in the world of this model.
        hand: the hand.
        taxel: per geom, index into the flat tactile vector, -1 where it is no taxel (ngeom,).
        table: id of the table's geom.
        palm, object_body: ids of bodies.
        hand_qpos: addresses of the hand's joints, in the order of its own model.
        object_qpos, object_dof: first addresses of the object's free joint.
        of_object: which coordinates are the object's (n,) bool.
        reach: length by which a unit of each coordinate moves a surface [m or 1] (n,).
        stiffness: of the motors' position servos (k,) [N m/rad or N/m].
    """

    def __init__(self, hand: Hand, name: str, folder: ObjectFolder | None) -> None:
        self.hand = hand
        spec = hand_with_object(hand, object_spec(name, folder))
        self._vertices = collision_vertices(object_spec(name, folder).compile())
        stand = spec.worldbody.add_body(name=TABLE, mocap=True)
        plane = stand.add_geom(name=TABLE, type=mujoco.mjtGeom.mjGEOM_PLANE, size=(1, 1, 1))
        plane.contype, plane.conaffinity = 0, 1  # meets the object alone
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.model = model = spec.compile()
        self.data = mujoco.MjData(model)
        self.table = model.geom(TABLE).id
        self.palm, self.object_body = model.body(hand.palm).id, model.body(OBJECT_BODY).id
        alone = hand_kinematics(hand).model
        joints = [model.joint(alone.joint(k).name) for k in range(alone.njnt)]
        free = model.joint(FREE_JOINT)
        self.hand_qpos = np.array([int(joint.qposadr[0]) for joint in joints])
        self.object_qpos, self.object_dof = int(free.qposadr[0]), int(free.dofadr[0])
        self.of_object = np.zeros(model.nv, dtype=bool)
        self.of_object[self.object_dof : self.object_dof + 6] = True
        self.taxel = np.full(model.ngeom, -1, dtype=np.int64)
        self._pitch = np.full(model.ngeom, np.nan)
        self._pad = np.full(model.ngeom, -1, dtype=np.int64)
        for index, (pad, offset, names) in enumerate(
            zip(hand.pads, hand.pad_offsets[:-1], taxel_names(hand), strict=True)
        ):
            for place, taxel in enumerate(names):
                if taxel:
                    self.taxel[model.geom(taxel).id] = offset + place
                    self._pitch[model.geom(taxel).id] = pad.array.pitch
                    self._pad[model.geom(taxel).id] = index
        of_object = np.array([model.geom_bodyid[g] == self.object_body for g in range(model.ngeom)])
        model.geom_margin[~of_object] = MARGIN
        model.jnt_margin[:] = STOP_MARGIN
        model.tendon_margin[:] = STOP_MARGIN
        self.reach = np.where(
            model.jnt_type[model.dof_jntid] == mujoco.mjtJoint.mjJNT_SLIDE, 1.0, ARM
        )
        self.reach[self.object_dof : self.object_dof + 3] = 1.0
        self.reach[self.object_dof + 3 : self.object_dof + 6] = RADIUS
        self._motors = np.array([model.actuator(motor).id for motor in hand.motor_names])
        self.stiffness = model.actuator_gainprm[self._motors, 0].copy()

    def contact_stiffness(self, modulus: float, thickness: float) -> np.ndarray:
        """Stiffness of every geom [N/m] (ngeom,): a taxel's rubber is E pitch² / thickness."""
        rubber = modulus * self._pitch**2 / thickness
        return np.where(self.taxel >= 0, rubber, HARD)

    def pose(self, joints: np.ndarray, object_in_palm: np.ndarray) -> np.ndarray:
        """Coordinates ``qpos`` for positions of the hand's joints and the object's pose (7,)."""
        data = self.data
        data.qpos[self.hand_qpos] = joints
        mujoco.mj_kinematics(self.model, data)
        palm = poses.body_pose(data, self.palm)
        data.qpos[self.object_qpos : self.object_qpos + 7] = poses.compose(palm, object_in_palm)
        return data.qpos.copy()

    def object_in_palm(self) -> np.ndarray:
        """Pose of the object in the palm frame (7,) at the last ``look``."""
        palm = poses.body_pose(self.data, self.palm)
        return poses.relative(palm, poses.body_pose(self.data, self.object_body))

    def move(self, qpos: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """Coordinates after a motion of all of them (n,)."""
        moved = qpos.copy()
        mujoco.mj_integratePos(self.model, moved, motion, 1.0)
        return moved

    def motion_between(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Motion of all coordinates (n,) from one set of them to another."""
        moved = np.zeros(self.model.nv)
        mujoco.mj_differentiatePos(self.model, moved, 1.0, first, second)
        return moved

    def lowest(self, qpos: np.ndarray, up: np.ndarray) -> float:
        """Height of the object's lowest point along a unit vector (3,) [m]."""
        pose = qpos[self.object_qpos : self.object_qpos + 7]
        return float((self._vertices @ rotation_of(pose[3:]).T @ up).min() + pose[:3] @ up)

    def put_table(self, height: float, up: np.ndarray) -> None:
        """Put the table's plane at a height [m] along a unit vector (3,)."""
        mujoco.mju_quatZ2Vec(self.data.mocap_quat[0], up)
        self.data.mocap_pos[0] = height * up

    def look(self, qpos: np.ndarray) -> None:
        """Go to coordinates; what other functions say is of them."""
        model, data = self.model, self.data
        data.qpos[:] = qpos
        find_transmission(model, data)

    def moment_arms(self) -> tuple[np.ndarray, np.ndarray]:
        """Moment arms of the motors about all coordinates (k, n), and motor positions (k,)."""
        arms = moment_arms(self.model, self.data)
        return arms[self._motors], self.data.actuator_length[self._motors].copy()

    def mechanism(self) -> Springs:
        """Couplings, end stops and springs of the hand, as bounded springs."""
        model, data = self.model, self.data
        data.ncon = 0
        mujoco.mj_makeConstraint(model, data)
        kinds = data.efc_type
        tied = kinds == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        stops = (kinds == mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT) | (
            kinds == mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON
        )
        taken = tied | stops
        rows = np.asarray(data.efc_J).reshape(-1, model.nv)[taken]
        stiffness = np.where(tied, COUPLING, STOP)[taken]
        force = -stiffness * data.efc_pos[taken]
        lower = np.where(tied, -np.inf, 0.0)[taken]
        upper = np.full(len(lower), np.inf)
        found = [Springs(rows, force, stiffness, lower, upper), *self._joint_springs()]
        return Springs(*(np.concatenate(parts) for parts in zip(*found, strict=True)))

    def _joint_springs(self) -> list[Springs]:
        """Springs of joints and tendons; below and above the slack of a tendon one each."""
        model, data = self.model, self.data
        found = []
        # Releases with springs of higher order have the linear stiffness first.
        of_joint = model.jnt_stiffness.reshape(model.njnt, -1)[:, 0]
        for joint in np.flatnonzero(of_joint > 0.0):
            at = model.jnt_qposadr[joint]
            row = np.zeros(model.nv)
            row[model.jnt_dofadr[joint]] = 1.0
            stretch = data.qpos[at] - model.qpos_spring[at]
            found.append(_spring(row, stretch, of_joint[joint], -np.inf, np.inf))
        if not model.ntendon:
            return found
        of_tendon = model.tendon_stiffness.reshape(model.ntendon, -1)[:, 0]
        rows = np.zeros((model.ntendon, model.nv))
        layout = model.ten_J_rownnz, model.ten_J_rowadr, model.ten_J_colind
        mujoco.mju_sparse2dense(rows, data.ten_J, *layout)
        for tendon in np.flatnonzero(of_tendon > 0.0):
            shortest, longest = model.tendon_lengthspring[tendon]
            length, k = data.ten_length[tendon], of_tendon[tendon]
            found.append(_spring(rows[tendon], length - shortest, k, 0.0, np.inf))
            found.append(_spring(rows[tendon], length - longest, k, -np.inf, 0.0))
        return found

    def readings(
        self, geoms: np.ndarray, points: np.ndarray, normal: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Pressure on the taxels by kind of array (pads, rows, columns) [kPa].

        A contact's force is felt by the taxels around the place where it acts, with the hand as at
        the last ``look``.

        Args:
            geoms: of the contacts (c, 2).
            points: where they are (c, 3) [m].
            normal: their normal forces (c,) [N].

        Returns:
            [kPa]; of what acts beyond the border of an array crosstalk shows a share beside it.
        """
        flat = np.zeros(self.hand.tactile_size)
        pad_of = self._pad[geoms].max(axis=1)
        for index, (pad, offset) in enumerate(
            zip(self.hand.pads, self.hand.pad_offsets[:-1], strict=True)
        ):
            felt = np.flatnonzero(pad_of == index)
            if not len(felt):
                continue
            body = self.model.body(pad.body).id
            local = (points[felt] - self.data.xpos[body]) @ self.data.xmat[body].reshape(3, 3)
            taxels, shares = pad.array.shares(local)
            pressure = 1e-3 * normal[felt] / pad.array.pitch**2
            np.add.at(flat, offset + taxels, pressure[:, None] * shares)
            neighbours, beside = pad.array.beside(local)
            np.add.at(flat, offset + neighbours, CROSSTALK * pressure[:, None] * beside)
        return self.hand.by_kind(flat)

    def touch(self) -> Touch:
        """What touches or nearly does: hand and object, object and table, the hand itself."""
        model, data = self.model, self.data
        mujoco.mj_collision(model, data)
        contact = data.contact
        geoms, points = contact.geom.copy(), contact.pos.copy()
        normal, gap = contact.frame[:, :3].copy(), contact.dist.copy()
        bodies = model.geom_bodyid[geoms]
        linear, spin = np.zeros((2, model.nbody, 3, model.nv))
        for body in np.unique(bodies):
            mujoco.mj_jacBody(model, data, linear[body], spin[body], int(body))
        arms = points[:, None, :] - data.xpos[bodies]
        turned = np.cross(spin[bodies], arms[..., None], axisa=2, axisb=2, axisc=2)
        moved = linear[bodies] + turned
        return Touch(geoms, points, normal, gap, moved[:, 1] - moved[:, 0])


def _spring(
    row: np.ndarray, stretch: float, stiffness: float, lower: float, upper: float
) -> Springs:
    one = np.ones(1)
    return Springs(row[None], -stiffness * stretch * one, stiffness * one, lower * one, upper * one)


@lru_cache(maxsize=16)
def _model(hand: Hand, name: str, folder: ObjectFolder | None) -> GraspModel:
    return GraspModel(hand, name, folder)


def grasp_model(hand: Hand, obj: ObjectInfo) -> GraspModel:
    """The model of a hand and an object, compiled once per process."""
    return _model(hand, obj.name, obj.folder)
