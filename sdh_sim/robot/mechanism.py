"""How the motors of any hand move its joints, from the compiled model.

At a posture MuJoCo gives the moment arms A of the motors about all joints (gears, fixed tendons)
and the rows E of the equalities (E q̇ = 0). The independent joints are those that no equality makes
dependent: all joint speeds are N times theirs, E N = 0. Two kinds of hands follow:

- motors and equalities fix every joint: joint speeds are S times the motors', with A S = 1 and
  E S = 0. Such a hand is described in motor coordinates, like one whose motors drive a joint each.
- some joints are passive, held by springs and stops alone. Where they are follows from forces: the
  hand alone, without weight, at rest at its servos' references. At a posture, a passive joint with
  a spring, or at a stop, counts as held: what it bears is left out, and S is that of the others.
  One with neither is free and bears nothing: the hand is then described in independent joints, with
  the transmission A N.

Murray, Li, Sastry: A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.robot.rest_posture import rest_posture, weightless

_RANK = 1e-8  # singular values below this share of the largest are zero
_CLOSE, _ROUNDS = 1e-10, 100  # of Newton's iteration
AT_STOP = 0.02  # from its range, as stops give way [rad or m]
_KEPT = 4096  # postures


class Motions(NamedTuple):
    """Joint motions at a posture.

    Attributes:
        columns: speeds of all joints per speed of each column (joints, n): of the motors, or of
            independent joints where some joint is free.
        transmission: moment arms of the motors about the columns (motors, n); None: the columns
            are the motors.
        driven: speeds of the columns per motor speed while the free joints keep still, too
            (n, motors); None as above.
    """

    columns: np.ndarray
    transmission: np.ndarray | None
    driven: np.ndarray | None


class Mechanism:
    """Motors, joints and what ties them, of a compiled hand.

    Attributes:
        passive: joints that neither a motor nor an equality moves, by name.
    """

    def __init__(self, model: mujoco.MjModel, motors: Sequence[str], hand: str) -> None:
        """Read the transmission.

        Args:
            model: the hand alone.
            motors: names of its actuators.
            hand: its name, for messages.

        Raises:
            HandError: no such actuator, more motors than they can move joints, or a passive joint
                that no spring and no stop holds.
        """
        self._model, self._data = model, mujoco.MjData(model)
        self._hand = hand
        self._known: dict[bytes, np.ndarray] = {}
        self._motors = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, n) for n in motors]
        if min(self._motors) < 0:
            name = motors[self._motors.index(-1)]
            raise HandError(f"hand {hand}: its model has no actuator {name}")
        self._rest = model.qpos0.copy()
        arms, ties = self._rows(self._rest)[:2]
        self._dependent = _dependent(ties, arms)
        self._independent = np.setdiff1d(np.arange(model.nv), self._dependent)
        reach = arms @ self._allowed(ties)
        if _rank(reach) < len(motors):
            raise HandError(
                f"hand {hand}: its {len(motors)} motors move only {_rank(reach)} joints that do "
                "not follow each other; leave motors out, or give each its own joint or tendon"
            )
        self._driven = _pivots(reach)
        left = np.setdiff1d(np.arange(len(self._independent)), self._driven)
        joints = self._independent[left]
        self.passive = tuple(model.joint(int(k)).name for k in joints)
        loose = [model.joint(int(k)).name for k in joints if not _is_held(model, int(k))]
        if loose:
            raise HandError(
                f"hand {hand}: no motor moves {', '.join(loose)}, and neither a spring nor a stop "
                "holds it; give the joint a stiffness or a range, or drive it"
            )

    def motions(self, joints: np.ndarray) -> Motions:
        """What moves at joint positions (joints,) [rad or m]."""
        arms, ties = self._rows(joints)[:2]
        if not self.passive:
            wanted = np.zeros((len(arms) + len(ties), len(arms)))
            wanted[: len(arms)] = np.eye(len(arms))
            found = np.linalg.lstsq(np.vstack((arms, ties)), wanted, rcond=None)[0]
            return Motions(found, None, None)
        passive = np.setdiff1d(np.arange(len(self._independent)), self._driven)
        free = [k for k in passive if not self._bears(int(self._independent[k]), joints)]
        allowed = self._allowed(ties)[:, [*self._driven, *free]]
        reach = arms @ allowed
        driven = np.zeros((allowed.shape[1], len(arms)))
        driven[: len(arms)] = np.linalg.inv(reach[:, : len(arms)])
        if not free:
            return Motions(allowed @ driven, None, None)
        return Motions(allowed, reach, driven)

    def positions(self, angles: np.ndarray) -> np.ndarray:
        """Positions of all joints [rad or m] where the motors are at positions (n,).

        With passive joints: where the hand comes to rest with its servos at these references.

        Raises:
            HandError: it does not come to rest, or equalities do not let the motors get there.
        """
        key = np.asarray(angles, dtype=float).tobytes()
        if key not in self._known:
            if len(self._known) >= _KEPT:
                self._known.clear()
            found = self._settled if self.passive else self._solved
            self._known[key] = found(np.frombuffer(key))
        return self._known[key].copy()

    def _bears(self, joint: int, joints: np.ndarray) -> bool:
        """Whether a passive joint has a spring, or is at a stop where the joints are."""
        model = self._model
        low, high = model.jnt_range[joint]
        at_stop = not low + AT_STOP < joints[joint] < high - AT_STOP
        if model.jnt_stiffness[joint] > 0.0 or (model.jnt_limited[joint] and at_stop):
            return True
        self._rows(joints)
        for tendon in _tendons_of(model, joint):
            low, high = model.tendon_range[tendon]
            at_stop = not low + AT_STOP < self._data.ten_length[tendon] < high - AT_STOP
            if model.tendon_stiffness[tendon] > 0.0 or (model.tendon_limited[tendon] and at_stop):
                return True
        return False

    def _rows(self, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Moment arms (motors, joints), rows of equalities (e, joints), motor positions, errors."""
        model, data = self._model, self._data
        data.qpos[:] = joints
        find_transmission(model, data)
        arms = moment_arms(model, data)
        data.ncon = 0
        mujoco.mj_makeConstraint(model, data)
        tied = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        ties = np.zeros((len(tied), model.nv))
        if len(tied):
            ties = np.asarray(data.efc_J).reshape(-1, model.nv)[tied].copy()
        lengths = data.actuator_length[self._motors].copy()
        return arms[self._motors], ties, lengths, data.efc_pos[tied].copy()

    def _allowed(self, ties: np.ndarray) -> np.ndarray:
        """Speeds of all joints per speed of each independent joint, N (joints, n)."""
        allowed = np.zeros((self._model.nv, len(self._independent)))
        allowed[self._independent, np.arange(len(self._independent))] = 1.0
        if len(self._dependent):
            found = np.linalg.lstsq(
                ties[:, self._dependent], -ties[:, self._independent], rcond=None
            )
            allowed[self._dependent] = found[0]
        return allowed

    def _solved(self, angles: np.ndarray) -> np.ndarray:
        """Joint positions by Newton's method; where all is linear the first step is exact."""
        joints = self._rest.copy()
        for _ in range(_ROUNDS):
            arms, ties, lengths, errors = self._rows(joints)
            wrong = np.concatenate((angles - lengths, -errors))
            if np.abs(wrong).max() < _CLOSE:
                return joints
            step = np.linalg.lstsq(np.vstack((arms, ties)), wrong, rcond=None)[0]
            joints += step * min(1.0, 0.5 / max(np.abs(step).max(), 1e-12))
        raise HandError(
            f"hand {self._hand}: its equalities do not let the motors get to "
            f"{' '.join(f'{v:.4g}' for v in angles)}"
        )

    def _settled(self, angles: np.ndarray) -> np.ndarray:
        found = rest_posture(self._weightless, self._motors, angles)
        if found is None:
            raise HandError(
                f"hand {self._hand}: with its motors at {' '.join(f'{v:.4g}' for v in angles)} it "
                f"does not come to rest; give the springs of {', '.join(self.passive)} more "
                "stiffness"
            )
        return found

    @cached_property
    def _weightless(self) -> mujoco.MjModel:
        return weightless(self._model, self._motors, self._rows(self._rest)[0])


def find_transmission(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Bring what MuJoCo knows of bodies, tendons and actuators to the coordinates in ``data``."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)
    mujoco.mj_transmission(model, data)


def moment_arms(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Moment arms of all actuators about all joint coordinates, after ``find_transmission``.

    Returns:
        (actuators, coordinates) [1 or m].
    """
    arms = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(
        arms,
        data.actuator_moment,
        data.moment_rownnz,
        data.moment_rowadr,
        data.moment_colind,
    )
    return arms


def _is_held(model: mujoco.MjModel, dof: int) -> bool:
    """Whether a spring or a stop acts on a joint, by itself or through a fixed tendon."""
    if model.jnt_stiffness[dof] > 0.0 or model.jnt_limited[dof]:
        return True
    return any(
        model.tendon_stiffness[k] > 0.0 or model.tendon_limited[k] for k in _tendons_of(model, dof)
    )


def _tendons_of(model: mujoco.MjModel, joint: int) -> list[int]:
    """Fixed tendons that a joint moves."""
    starts, counts = model.tendon_adr, model.tendon_num
    return [
        k
        for k in range(model.ntendon)
        if joint in model.wrap_objid[starts[k] : starts[k] + counts[k]]
    ]


def _dependent(ties: np.ndarray, arms: np.ndarray) -> np.ndarray:
    """Joints that equalities make dependent: as many as they can, motors' own ones last."""
    driven = np.abs(arms).sum(axis=0) > 0.0
    order = [*np.flatnonzero(~driven), *np.flatnonzero(driven)]
    chosen: list[int] = []
    for joint in order:
        if _rank(ties[:, [*chosen, joint]]) > len(chosen):
            chosen.append(int(joint))
    return np.array(sorted(chosen), dtype=np.int64)


def _pivots(reach: np.ndarray) -> np.ndarray:
    """Columns that make a square matrix of full rank, those with the largest entries first."""
    order = np.argsort(-np.abs(reach).max(axis=0), kind="stable")
    chosen: list[int] = []
    for column in order:
        if _rank(reach[:, [*chosen, int(column)]]) > len(chosen):
            chosen.append(int(column))
    return np.array(chosen, dtype=np.int64)


def _rank(matrix: np.ndarray) -> int:
    if not matrix.size:
        return 0
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > _RANK * max(float(values[0]), 1e-300)).sum())
