"""What a motor's gear does to a load that pushes back: yield, hold or lock.

With a torque limit τ̄ and the friction τ_f of the gear a motor that pushes gives the joint at most τ̄
with each drive. A load on the joint turns it back

- ``yield``: beyond τ̄; the gear has no friction;
- ``hold``: beyond τ̄ + τ_f. This is Coulomb friction of τ_f / 2 either way behind a motor of
  τ̄ + τ_f / 2: what it pushes with is less by the friction, what it bears is more by it;
- ``lock``: never, as with a worm gear. The joint moves only in the sense of its motor's torque, and
  keeps its position against all else.

Coulomb friction is MuJoCo's ``frictionloss``. A locked joint is at a stop that moves with it in the
sense of the motor's torque and never back, so that it does not creep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

YIELD, HOLD, LOCK = "yield", "hold", "lock"
STIFF = (0.004, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""Solver parameters of friction and stops: 1 N m moves a locked joint by some µrad."""
SETTLES = 0.2  # of rubber, which takes 50 to 90 ms [s]
_FAR = 1e6  # stop of a joint that has none [rad or m]


def _nothing() -> np.ndarray:
    return np.zeros(0)


@dataclass(frozen=True)
class Drives:
    """The drives of a compiled scene.

    Attributes:
        kind: of them all.
        friction: of each gear either way, τ_f / 2 (n,) [N m or N]; empty for none.
        stops: of a locked joint or tendon, from the model (n, 2) [rad or m]; empty for others.
    """

    kind: str = YIELD
    friction: np.ndarray = field(default_factory=_nothing)
    stops: np.ndarray = field(default_factory=_nothing)


def give_drives(
    spec: mujoco.MjSpec, motors: Sequence[str], limits: np.ndarray, kind: str, share: float
) -> None:
    """Give motors of a model their limits and drives.

    Args:
        spec: changed in place.
        motors: names of the actuators (n,).
        limits: of their torques (n,) [N m or N].
        kind: ``yield``, ``hold`` or ``lock``.
        share: friction τ_f of the gears as a share of the limit, for ``hold``.
    """
    for name, limit in zip(motors, limits, strict=True):
        motor = spec.actuator(name)
        friction = 0.5 * share * limit if kind == HOLD else 0.0
        motor.forcerange = [-limit - friction, limit + friction]
        if kind == YIELD:
            continue
        driven = _driven(spec, motor)
        if kind == HOLD:
            driven.frictionloss += friction * abs(motor.gear[0])
            driven.solref_friction, driven.solimp_friction = STIFF
        else:
            if driven.range[0] >= driven.range[1]:
                driven.range = [-_FAR, _FAR]
            driven.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            driven.solref_limit, driven.solimp_limit = STIFF


def drives_in(
    model: mujoco.MjModel, motors: np.ndarray, limits: np.ndarray, kind: str, share: float
) -> Drives:
    """What ``give_drives`` made of a model, compiled; ``motors`` are ids of the actuators."""
    if kind == HOLD:
        return Drives(kind, 0.5 * share * limits)
    if kind == LOCK:
        return Drives(kind, stops=np.array([_ranges(model, k)[_place(model, k)] for k in motors]))
    return Drives()


def _driven(spec: mujoco.MjSpec, motor: mujoco.MjsActuator) -> mujoco.MjsJoint | mujoco.MjsTendon:
    """The joint or tendon that a motor drives."""
    if motor.trntype == mujoco.mjtTrn.mjTRN_TENDON:
        return spec.tendon(motor.target)
    return spec.joint(motor.target)


def _on_tendon(model: mujoco.MjModel, motor: int) -> bool:
    return bool(model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_TENDON)


def _ranges(model: mujoco.MjModel, motor: int) -> np.ndarray:
    """The array that holds the stops of what a motor drives."""
    return model.tendon_range if _on_tendon(model, motor) else model.jnt_range


def _place(model: mujoco.MjModel, motor: int) -> int:
    return int(model.actuator_trnid[motor, 0])


class SelfLocking:
    """Stops that move with locked joints in the sense of their motors' torques, tick by tick.

    A position is kept once the joint has been there, or beyond, for ``SETTLES``: until then the
    rubber of this contact model has not built up its force, and a stop would keep a pad pressed in
    deeper than its motor can press it.

    Args:
        model: of a scene with drives of the kind ``lock``; its stops are those of the last one who
            moved them, since trials share it.
        motors: ids of the actuators (n,).
        stops: the joints' own (n, 2).
        tick_time: [s].
    """

    def __init__(
        self, model: mujoco.MjModel, motors: np.ndarray, stops: np.ndarray, tick_time: float
    ) -> None:
        self._model, self._stops, self._motors = model, stops, motors
        places = np.array([_place(model, k) for k in motors])
        self._sense = np.sign(model.actuator_gear[motors, 0])
        self._on_tendon = np.array([_on_tendon(model, k) for k in motors])
        self._joints, self._tendons = places[~self._on_tendon], places[self._on_tendon]
        self._addresses = model.jnt_qposadr[self._joints]
        self._ticks = max(1, round(SETTLES / tick_time))
        self.free()

    def free(self) -> None:
        """Forget where the joints are: they have been put somewhere else."""
        self._kept = self._stops.copy()  # (n, 2)
        self._past = np.full((self._ticks, len(self._motors)), np.nan)  # positions, newest last
        self._put()

    def before_tick(self, data: mujoco.MjData) -> None:
        """Move the stops on to where the joints have been, as the motors' torques allow."""
        at = np.empty(len(self._motors))
        at[~self._on_tendon] = data.qpos[self._addresses]
        at[self._on_tendon] = data.ten_length[self._tendons]
        self._past = np.vstack((self._past[1:], at))
        if np.isnan(self._past).any():  # not that long here
            self._put()
            return
        torque = self._sense * data.actuator_force[self._motors]
        low, high = np.maximum(self._kept[:, 0], self._past.min(axis=0)), self._stops[:, 1]
        kept_high = np.minimum(self._kept[:, 1], self._past.max(axis=0))
        low = np.where(torque >= 0.0, low, self._stops[:, 0])
        self._kept = np.column_stack((low, np.where(torque < 0.0, kept_high, high)))
        self._put()

    def state(self) -> np.ndarray:
        """All that it knows, for ``restore``."""
        return np.concatenate((self._kept.ravel(), self._past.ravel()))

    def restore(self, state: np.ndarray) -> np.ndarray:
        """Go back to a state at the end of an array; returns what stands before it."""
        count = self._kept.size + self._past.size
        own = state[-count:]
        self._kept = own[: self._kept.size].reshape(self._kept.shape).copy()
        self._past = own[self._kept.size :].reshape(self._past.shape).copy()
        self._put()
        return state[:-count]

    def _put(self) -> None:
        """Write the stops into the model."""
        self._model.jnt_range[self._joints] = self._kept[~self._on_tendon]
        self._model.tendon_range[self._tendons] = self._kept[self._on_tendon]
