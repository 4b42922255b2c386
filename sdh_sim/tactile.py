"""From MuJoCo's contact forces to tactile arrays; what a snapshot of the hand holds."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sdh_sim import sdh2_constants as c
from sdh_sim.scene import PAD_OFFSETS, TACTILE_SIZE, Scene


def taxel_forces(scene: Scene, data: mujoco.MjData) -> np.ndarray:
    """Normal force on every taxel, flat (486,) [N], cells that do not exist 0."""
    forces = np.zeros(TACTILE_SIZE)
    if data.ncon == 0 or data.nefc == 0:
        return forces
    contact = data.contact
    address = contact.efc_address
    # A contact out of reach of the constraint solver has no row.
    alive = address >= 0
    normal = data.efc_force[address[alive]]
    for geom in contact.geom[alive].T:
        taxel = scene.taxel[geom]
        hit = taxel >= 0
        np.add.at(forces, taxel[hit], normal[hit])
    return forces


def arrays(flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The flat tactile vector as arrays: proximal (3, 14, 6), distal (3, 13, 6)."""
    middle = PAD_OFFSETS[3]
    return (
        flat[:middle].reshape(3, c.TAXEL_ROWS["proximal"], c.TAXEL_COLUMNS),
        flat[middle:].reshape(3, c.TAXEL_ROWS["distal"], c.TAXEL_COLUMNS),
    )


@dataclass(frozen=True)
class TactileSnapshot:
    """What the hand knows after acquisition; predictions see this and nothing else of a trial.

    Attributes:
        proximal: readings (3, 14, 6) [kPa], fingers as in ``sdh2_constants.FINGERS``.
        distal: readings (3, 13, 6) [kPa].
        joint_angles: motor angles (7,) [rad].
        motor_torques: motor torques (7,) [N m].
        object_pose_hand: pose of the object in the palm frame, x y z qw qx qy qz (7,).
        hand_pose_world: pose of the palm in the world (7,).
    """

    proximal: np.ndarray
    distal: np.ndarray
    joint_angles: np.ndarray
    motor_torques: np.ndarray
    object_pose_hand: np.ndarray
    hand_pose_world: np.ndarray
