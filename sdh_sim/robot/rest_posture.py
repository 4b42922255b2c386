"""Where a hand with passive joints comes to rest: without weight, at its servos' references."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np

_BLOCKS, _STEPS, _STILL = 100, 200, 1e-6  # at rest: no joint moves as far in a block of steps


def rest_posture(
    model: mujoco.MjModel, motors: Sequence[int], angles: np.ndarray
) -> np.ndarray | None:
    """Positions of all joints at rest [rad or m]; None: the hand does not come to rest.

    Setting speeds to zero whenever the kinetic energy falls (dynamic relaxation; Cundall:
    Explicit finite-difference methods in geomechanics, 1976) finds a rest where nothing damps, too.

    Args:
        model: from ``weightless``.
        motors: ids of its actuators.
        angles: their references (n,) [rad or m].
    """
    data = mujoco.MjData(model)
    data.ctrl[list(motors)] = angles
    for _ in range(_BLOCKS):
        before = data.qpos.copy()
        for _ in range(_STEPS):
            mujoco.mj_step(model, data)
            if data.qvel @ data.qacc < 0.0:
                data.qvel[:] = 0.0
        if not np.isfinite(data.qpos).all():
            return None
        if np.abs(data.qpos - before).max() < _STILL:
            return data.qpos.copy()
    return None


def weightless(
    model: mujoco.MjModel, motors: Sequence[int], moment_arms: np.ndarray
) -> mujoco.MjModel:
    """A copy of a hand without weight and contacts, made to come to rest quickly.

    Where it rests does not depend on inertia and damping. So damping goes, dry friction, too, which
    would leave the rest open, and joints get the inertia with which the stiffest motion is slow
    enough for the time step: K dt², by Gershgorin's bound on the stiffness K.

    Args:
        model: the hand.
        motors: ids of its actuators.
        moment_arms: of the motors about the joints (n, joints).
    """
    still = copy.copy(model)
    still.opt.gravity[:] = 0.0
    still.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    flags = mujoco.mjtDisableBit
    still.opt.disableflags |= flags.mjDSBL_CONTACT | flags.mjDSBL_AUTORESET
    for losses in ("dof_frictionloss", "tendon_frictionloss", "dof_damping", "tendon_damping"):
        getattr(still, losses)[:] = 0.0
    still.actuator_biasprm[:, 2] = 0.0
    # Releases with springs of higher order have the linear stiffness first.
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[:, 0].copy()
    arms = np.abs(moment_arms)
    stiffness += arms.T @ (model.actuator_gainprm[list(motors), 0] * arms.sum(axis=1))
    for k in range(model.ntendon):
        span = slice(model.tendon_adr[k], model.tendon_adr[k] + model.tendon_num[k])
        spring = model.tendon_stiffness.reshape(model.ntendon, -1)[k, 0]
        coefficients = np.abs(model.wrap_prm[span])
        stiffness[model.wrap_objid[span]] += spring * coefficients * coefficients.sum()
    still.dof_armature[:] = np.maximum(model.dof_armature, stiffness * model.opt.timestep**2)
    return still
