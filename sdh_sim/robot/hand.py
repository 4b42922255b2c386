"""The hand as the controller and the metrics know it: where it is read from, and its kinematics."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.model_files import models_dir
from sdh_sim.robot.closing import Closing
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.hand_file import read_hand_file
from sdh_sim.robot.hand_model import taxel_name
from sdh_sim.robot.mechanism import Mechanism, Motions
from sdh_sim.robot.toml_table import FILE
from sdh_sim.settings import DEFAULT_HAND

HAND = "hand/"  # prefix of its names in a workcell


@lru_cache(maxsize=8)
def built_in_hand(name: str = DEFAULT_HAND) -> Hand:
    """A hand of the models, read once per process.

    Raises:
        HandError: no such hand.
    """
    path = models_dir() / name / FILE
    if not path.is_file():
        known = sorted(p.parent.name for p in models_dir().glob(f"*/{FILE}"))
        raise HandError(f"hand: got {name!r:.80}; choose one of {', '.join(known)}")
    return read_hand_file(path.read_bytes(), path.parent, _spans)


def _spans(model: Path) -> dict[str, tuple[float, float]]:
    """Ranges of the actuators of a model that have one, by name [rad or m].

    A servo's reference may go further than the joint, so that it pushes at the end of its way too.
    """
    spec = mujoco.MjSpec.from_file(str(model))
    spans = {}
    for actuator in spec.actuators:
        low, high = actuator.ctrlrange
        joint = spec.joint(actuator.target)
        if actuator.trntype == mujoco.mjtTrn.mjTRN_JOINT and joint is not None:
            ends = np.sort(joint.range * actuator.gear[0])
            if ends[0] < ends[1]:
                low, high = max(low, ends[0]), min(high, ends[1])
        if low < high:
            spans[actuator.name] = (float(low), float(high))
    return spans


def preshape_closing(name: str) -> Closing:
    """The closing of a preshape of the SDH-2; raises SettingsError where there is none."""
    return built_in_hand().closing(name)


def closing_between(open: object, closed: object) -> Closing:
    """The closing of the SDH-2 between two postures; as ``Hand.closing_between``."""
    return built_in_hand().closing_between(open, closed)


def hand_spec(hand: Hand) -> mujoco.MjSpec:
    """The model of a hand, new at each call."""
    if hand.made is not None:
        return hand.made.copy()
    return mujoco.MjSpec.from_file(str(hand.model))


def taxel_names(hand: Hand) -> list[list[str]]:
    """Names of the taxels' geoms, row by row, for each pad; empty where there is no taxel."""
    return [
        [
            taxel_name(pad, row, column) if pad.array.live[row, column] else ""
            for row in range(pad.array.shape[0])
            for column in range(pad.array.shape[1])
        ]
        for pad in hand.pads
    ]


def strip_taxels(spec: mujoco.MjSpec, hand: Hand) -> None:
    """Remove the taxel geoms from a spec: kinematics and drawings do without them."""
    taxels = {name for names in taxel_names(hand) for name in names}
    for geom in list(spec.geoms):
        if geom.name and geom.name in taxels:
            spec.delete(geom)


def joint_table(hand: Hand) -> list[tuple[str, str, float, tuple[float, float], float]]:
    """Rows (joint, motor, rated torque [N m or N], range [rad or m], speed [rad/s or m/s])."""
    moved = hand_kinematics(hand).selection != 0.0
    model = hand_kinematics(hand).model
    rows = []
    for index, motor in enumerate(hand.motors):
        joints = [model.joint(int(k)).name for k in np.flatnonzero(moved[:, index])]
        for joint in sorted(joints, key=lambda name: name != motor.name):
            coupled = "" if joint == joints[0] or joint == motor.name else " (coupled)"
            rows.append((joint, f"{index}{coupled}", motor.rated, motor.span, motor.speed))
    return rows


class HandKinematics:
    """Forward kinematics and Jacobians of the hand alone, by MuJoCo on the hand's own MJCF.

    Attributes:
        hand: the hand.
        model: it, without taxel geoms; its world frame is the mounting face.
        mechanism: how motors move joints; None where each drives a joint of its own, and joints
            without a motor follow one in proportion.
        selection: all joint positions are this times the motors', (joints, motors); with a
            mechanism, joint speeds at the model's reference posture, passive joints still.
    """

    def __init__(self, hand: Hand | None = None) -> None:
        self.hand = hand or built_in_hand()
        spec = hand_spec(self.hand)
        strip_taxels(spec, self.hand)
        self.model = spec.compile()
        self.mechanism: Mechanism | None = None
        # The same matrix takes joint to motor Jacobians.
        if _is_direct(self.model, self.hand):
            self.selection = _selection(self.model, self.hand)
        else:
            self.mechanism = Mechanism(self.model, self.hand.motor_names, self.hand.name)
            motions = self.mechanism.motions(self.model.qpos0)
            columns, driven = motions.columns, motions.driven
            self.selection = columns if driven is None else columns @ driven
        self.selection.setflags(write=False)

    @property
    def passive(self) -> tuple[str, ...]:
        """Joints that springs and stops alone hold, by name."""
        return self.mechanism.passive if self.mechanism is not None else ()

    def at(self, angles: np.ndarray, joints: np.ndarray | None = None) -> HandPosture:
        """The hand at motor positions (n,) [rad or m].

        Args:
            angles: positions of the motors.
            joints: of all joints where they are known; None: as ``joint_positions`` has them.
        """
        return HandPosture(self, self.joint_positions(angles) if joints is None else joints)

    def joint_positions(self, angles: np.ndarray) -> np.ndarray:
        """Positions of all joints, coupled ones too, in the MJCF's order [rad or m].

        With passive joints these are where nothing but springs and stops holds them.
        """
        if self.mechanism is not None:
            return self.mechanism.positions(angles)
        return self.selection @ angles

    def motions(self, joints: np.ndarray) -> Motions:
        """What moves at positions of all joints [rad or m]."""
        if self.mechanism is not None:
            return self.mechanism.motions(joints)
        return Motions(self.selection, None, None)

    def transmission(
        self, angles: np.ndarray, joints: np.ndarray | None = None
    ) -> np.ndarray | None:
        """Moment arms of the motors about the columns of the Jacobians; arguments as ``at``."""
        if not self.passive:
            return None
        return self.motions(self.joint_positions(angles) if joints is None else joints).transmission

    def palm_offset(self) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) [m] and quaternion (4,) of the palm on the mounting face."""
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        palm = self.model.body(self.hand.palm).id
        return data.xpos[palm].copy(), data.xquat[palm].copy()


def _is_direct(model: mujoco.MjModel, hand: Hand) -> bool:
    """Whether every motor drives a joint and all others follow one in proportion, from zero."""
    follows = model.eq_type == mujoco.mjtEq.mjEQ_JOINT
    if not follows.all() or model.qpos0.any() or (model.eq_obj2id < 0).any():
        return False
    if model.eq_data[:, [0, 2, 3, 4]].any():
        return False
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, n) for n in hand.motor_names]
    on_joint = model.actuator_trntype[[k for k in ids if k >= 0]] == mujoco.mjtTrn.mjTRN_JOINT
    joints = {int(model.actuator_trnid[k, 0]) for k in ids if k >= 0}
    own = len(joints) == len(ids) and on_joint.all()
    return bool(own) and len(joints | set(model.eq_obj1id.tolist())) == model.njnt


def _selection(model: mujoco.MjModel, hand: Hand) -> np.ndarray:
    """What each joint moves by per motion of each motor (joints, motors), from the compiled model.

    Raises:
        HandError: a motor that is no actuator on a joint, or a joint that no motor moves.
    """
    selection = np.zeros((model.nq, len(hand.motors)))
    for index, motor in enumerate(hand.motors):
        actuator = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, motor.name)
        if actuator < 0:
            raise HandError(f"hand {hand.name}: its model has no actuator {motor.name}")
        if model.actuator_trntype[actuator] != mujoco.mjtTrn.mjTRN_JOINT:
            raise HandError(f"hand {hand.name}: the actuator {motor.name} does not drive a joint")
        joint = model.actuator_trnid[actuator, 0]
        selection[model.jnt_qposadr[joint], index] = 1.0 / model.actuator_gear[actuator, 0]
    for k in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        follower, leader = model.eq_obj1id[k], model.eq_obj2id[k]
        ratio = model.eq_data[k, 1]
        selection[model.jnt_qposadr[follower]] = ratio * selection[model.jnt_qposadr[leader]]
    idle = np.flatnonzero(~selection.any(axis=1))
    if len(idle):
        name = model.joint(int(idle[0])).name
        raise HandError(f"hand {hand.name}: no motor moves the joint {name}")
    return selection


@lru_cache(maxsize=8)
def hand_kinematics(hand: Hand | None = None) -> HandKinematics:
    """The kinematics of a hand (None: the SDH-2), compiled once per process."""
    return HandKinematics(hand) if hand is not None else hand_kinematics(built_in_hand())


class HandPosture:
    """The hand at one posture: where its links are, and how they move with its motors.

    Args:
        kinematics: the hand.
        joints: positions of all its joints [rad or m].

    Attributes:
        transmission: moment arms of the motors about the n columns of the Jacobians (motors, n);
            None: the columns are the motors.
    """

    def __init__(self, kinematics: HandKinematics, joints: np.ndarray) -> None:
        self._model = kinematics.model
        self._selection, self.transmission, self._driven = kinematics.motions(joints)
        self._data = mujoco.MjData(self._model)
        self._data.qpos[:] = joints
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        palm = self._model.body(kinematics.hand.palm).id
        self._origin = self._data.xpos[palm].copy()
        self._axes = self._data.xmat[palm].reshape(3, 3).copy()

    def link(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) [m] and rotation (3, 3) of a body's frame in the palm frame."""
        index = self._model.body(body).id
        offset = self._data.xpos[index] - self._origin
        return self._axes.T @ offset, self._axes.T @ self._data.xmat[index].reshape(3, 3)

    def jacobian(self, body: str, point: np.ndarray) -> np.ndarray:
        """Velocity of a point of a body per column's velocity, in the palm frame (3, n) [m/rad].

        The columns are the motors, or independent joints where ``transmission`` says so.

        Args:
            body: body that the point is fixed to.
            point: the point in the palm frame (3,) [m].
        """
        world = self._origin + self._axes @ point
        full = np.zeros((3, self._model.nv))
        mujoco.mj_jac(self._model, self._data, full, None, world, self._model.body(body).id)
        return self._axes.T @ full @ self._selection

    def of_motors(self, jacobian: np.ndarray) -> np.ndarray:
        """A Jacobian (…, n) per motor velocity (…, motors), free joints kept still."""
        return jacobian if self._driven is None else jacobian @ self._driven

    def spin_jacobian(self, body: str) -> np.ndarray:
        """Angular velocity of a body per column's velocity, in the palm frame (3, n)."""
        full = np.zeros((3, self._model.nv))
        mujoco.mj_jacBody(self._model, self._data, None, full, self._model.body(body).id)
        return self._axes.T @ full @ self._selection
