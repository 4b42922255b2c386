"""What happened during a trial, sampled at 30 Hz: the input of recordings and pictures."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

from sdh_sim.cell import Scene
from sdh_sim.cell.contacts import forces_on_object, taxel_forces
from sdh_sim.cell.current_poses import CurrentPoses
from sdh_sim.metrics import Prediction
from sdh_sim.records import TrialRow

RATE = 30.0  # [Hz]


@dataclass(frozen=True)
class TrialLog:
    """Time series of one trial.

    Attributes:
        scene: the compiled scene.
        row: the trial's row of the table.
        prediction: contacts and q*, None when the trial ended before the snapshot.
        lifted_off: the same at lift-off, None where no snapshot was taken then.
        time: (n,) [s].
        phase: name of the phase of every sample.
        qpos: generalised positions (n, nq).
        body_position: of every body (n, nbody, 3) [m] in the world.
        body_quat: (n, nbody, 4) w x y z.
        tactile: normal force per taxel (n, 486) [N].
        motor_torque: (n, 7) [N m].
        object_height: of the object's frame over its place on the table (n,) [m].
        contact_points: per sample, contacts of the object with the hand (k, 3) [m] in the world.
            Like forces and torques they are those of the simulation's last step, at its beginning;
            joints and bodies are at its end.
        contact_forces: per sample, force on the object at those contacts (k, 3) [N].
    """

    scene: Scene
    row: TrialRow
    prediction: Prediction | None
    lifted_off: Prediction | None
    time: np.ndarray
    phase: tuple[str, ...]
    qpos: np.ndarray
    body_position: np.ndarray
    body_quat: np.ndarray
    tactile: np.ndarray
    motor_torque: np.ndarray
    object_height: np.ndarray
    contact_points: tuple[np.ndarray, ...]
    contact_forces: tuple[np.ndarray, ...]


@dataclass
class LogWriter:
    """An observer of a simulation that takes a sample when one is due."""

    _rows: dict[str, list] = field(default_factory=dict)
    _next: float = 0.0
    _poses: CurrentPoses | None = None

    def after_tick(self, scene: Scene, data: mujoco.MjData, phase: str) -> None:
        """Take a sample when one is due."""
        if data.time < self._next:
            return
        self._next += 1.0 / RATE
        if self._poses is None:
            self._poses = CurrentPoses(scene.model)
        bearing = forces_on_object(scene, data)
        now = self._poses.of(data)
        values = {
            "time": float(data.time),
            "phase": phase,
            "qpos": data.qpos.copy(),
            "body_position": now.xpos.copy(),
            "body_quat": now.xquat.copy(),
            "tactile": taxel_forces(scene, data),
            "motor_torque": data.actuator_force[scene.motors].copy(),
            "object_height": float(now.xpos[scene.object_body, 2]),
            "contact_points": bearing.points,
            "contact_forces": bearing.forces,
        }
        for key, value in values.items():
            self._rows.setdefault(key, []).append(value)

    def finish(
        self,
        scene: Scene,
        row: TrialRow,
        prediction: Prediction | None,
        lifted_off: Prediction | None = None,
    ) -> TrialLog:
        """The log so far."""
        rows = self._rows
        height = np.array(rows["object_height"])
        return TrialLog(
            scene=scene,
            row=row,
            prediction=prediction,
            lifted_off=lifted_off,
            time=np.array(rows["time"]),
            phase=tuple(rows["phase"]),
            qpos=np.array(rows["qpos"]),
            body_position=np.array(rows["body_position"]),
            body_quat=np.array(rows["body_quat"]),
            tactile=np.array(rows["tactile"]),
            motor_torque=np.array(rows["motor_torque"]),
            object_height=height - height[0],
            contact_points=tuple(rows["contact_points"]),
            contact_forces=tuple(rows["contact_forces"]),
        )
