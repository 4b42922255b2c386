"""Poses of the bodies as the joints have them now.

After a step MuJoCo's ``xpos`` and ``xquat`` are those of the step's beginning, as are contacts and
forces; ``qpos`` is that of its end. Contacts belong with the former. What is told of the bodies
beside joint positions must come from ``qpos`` too: here.
"""

from __future__ import annotations

import mujoco
import numpy as np


class CurrentPoses:
    """Kinematics of a model apart from its simulation, which they leave as it is.

    Args:
        model: of the simulation.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._data = mujoco.MjData(model)

    def of(self, data: mujoco.MjData) -> mujoco.MjData:
        """Data whose ``xpos``, ``xquat`` and ``xmat`` belong to the ``qpos`` of a simulation.

        Valid until the next call.
        """
        np.copyto(self._data.qpos, data.qpos)
        mujoco.mj_kinematics(self._model, self._data)
        return self._data
