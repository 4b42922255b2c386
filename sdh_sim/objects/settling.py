"""Whether an object is at rest on the table, and where it comes to rest, by simulation.

The table yields: an object sinks by about 0.3 mm and tilts towards where its weight lies, and one
on a narrow base may tip over that would stand on a rigid plane. So statics propose a pose, and the
simulation of the trials, without robot, decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sdh_sim.model_files import models_dir
from sdh_sim.objects.contact_settings import HARD_SOLREF
from sdh_sim.poses import turn_between

PLACE = (0.45, 0.0)  # anywhere on the table [m]
PUSH = 1e-5  # at the start: what balances on a line would stay there by symmetry alone [rad/s]
SETTLES, WATCHED = 1.5, 0.5  # time to come to rest, and how long it is watched then [s]


@dataclass(frozen=True)
class Rest:
    """How an object came to rest.

    Attributes:
        quat: its orientation, w x y z (4,).
        height: of its frame over the table [m].
        turned: angle from where it started [rad].
        speed: of its frame at the end [m/s]; infinite where the simulation diverged.
        turn_rate: of its orientation at the end [rad/s].
    """

    quat: np.ndarray
    height: float
    turned: float
    speed: float
    turn_rate: float


def come_to_rest(spec: mujoco.MjSpec, friction: float) -> Rest:
    """Put an object on the table as it stands and wait until it is at rest.

    Args:
        spec: the body ``object`` with mass and pose.
        friction: Coulomb's coefficient of the object.
    """
    scene = mujoco.MjSpec.from_file(str(models_dir() / "cell" / "cell.xml"))
    scene.attach(spec.copy(), prefix="object/", frame=scene.worldbody.add_frame())
    scene.body("object/object").add_freejoint(name="free")
    model = scene.compile()
    table, body = model.geom("table").id, model.body("object/object").id
    model.geom_solref[model.geom_bodyid == body] = HARD_SOLREF
    model.geom_friction[table, 0] = min(model.geom_friction[table, 0], friction)
    data = mujoco.MjData(model)
    data.qpos[:2] += PLACE
    data.qvel[3:5] = PUSH
    start = data.qpos.copy()
    settled = start
    for duration in (SETTLES, WATCHED):
        settled = data.qpos.copy()
        for _ in range(round(duration / model.opt.timestep)):
            mujoco.mj_step(model, data)
            if not np.isfinite(data.qpos).all():
                return Rest(start[3:], float(start[2]), np.pi, np.inf, np.inf)
    return Rest(
        quat=data.qpos[3:].copy(),
        height=float(data.qpos[2]),
        turned=turn_between(start, data.qpos),
        speed=float(np.linalg.norm(data.qpos[:3] - settled[:3])) / WATCHED,
        turn_rate=turn_between(settled, data.qpos) / WATCHED,
    )
