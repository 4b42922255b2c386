"""Check of motion: what is held slips while the hand turns about a distant axis, by a known law.

MuJoCo's constraints ask for J v̇ and leave out J̇ v. A hand on a base that turns evenly with ω
accelerates by ω² towards the axis at every point, and this is in J̇ v alone; an object of a free
joint has all of its acceleration in J v̇. A contact that sticks therefore sees an acceleration of
ω² r that is not there, with r the distance of the object's centre of mass from the axis, and slips
along the radius until its damping makes up for it: v = ω² r / b. Neither friction nor time step
nor solver are in it. An arm's joints that turn in a lift do the same.
"""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.validation.friction import CLAMP_ANGLES, CLAMP_BOX, CLAMP_PLACE, CLAMP_PUSH
from experiments.validation.result_rows import Result, Row
from experiments.validation.rig_readings import advance, squeezed, touches
from experiments.validation.rigs import HONEST, Spoil, gripper, settings_for
from sdh_sim.cell import Scene
from sdh_sim.cell.scene_builder import PAD_IMPEDANCE
from sdh_sim.robot import HAND

# Speed of the base [rad/s] and distance of the hand from its axis [m]: what the joints of the arm
# reach in a lift, and more.
TURNS = ((0.3, 0.5), (0.6, 0.5), (0.3, 1.0), (0.3, 0.0))
STEADY, WATCHED = 0.4, 0.4  # until an even slip, and measured for so long [s]
FINE = 0.0005  # time step [s]: its share of the slip's time constant is what the law leaves out


def turning_base(short: bool = False, spoil: Spoil = HONEST) -> Result:
    """Slip of a clamped box along the radius of a base that turns evenly, against ω² r / b."""
    rows = []
    for speed, radius in TURNS[:1] if short else TURNS:
        scene = gripper(CLAMP_PLACE, [CLAMP_BOX], True, settings_for(FINE), 0.8, spoil,
                        radius=radius)  # fmt: skip
        data = squeezed(scene, CLAMP_ANGLES, CLAMP_PUSH)
        _set_turning(scene, data, speed)
        advance(scene, data, STEADY)
        before = _out(scene, data)
        advance(scene, data, WATCHED)
        slip = (_out(scene, data) - before) / WATCHED
        law = speed**2 * (radius + CLAMP_PLACE.position[0]) / _damping(scene, data, spoil)
        rows.append(Row(
            f"base turns with {speed:g} rad/s, {radius:g} m away: slip along the radius", "µm/s",
            1e6 * law, 1e6 * slip, 0.03, "the way inwards changes forces; damping over a step",
            scale=1e6 * max(law, 1e-4),
        ))  # fmt: skip
    return Result(tuple(rows))


def _set_turning(scene: Scene, data: mujoco.MjData, speed: float) -> None:
    """Give all the speed of a rigid body that turns about the base's axis."""
    turn, dof = scene.model.joint("turn"), scene.object_dof
    data.qvel[:] = 0.0
    data.qvel[turn.dofadr[0]] = speed
    arm = data.xpos[scene.object_body] - data.xanchor[turn.id]
    data.qvel[dof : dof + 3] = np.cross((0.0, 0.0, speed), arm)
    axes = data.xmat[scene.object_body].reshape(3, 3)
    data.qvel[dof + 3 : dof + 6] = axes.T @ (0.0, 0.0, speed)


def _out(scene: Scene, data: mujoco.MjData) -> float:
    """Place of the box along the palm's x axis, which points away from the base's [m]."""
    mujoco.mj_kinematics(scene.model, data)
    axes = data.xmat[scene.palm].reshape(3, 3)
    return float(axes[:, 0] @ (data.xpos[scene.object_body] - data.xpos[scene.palm]))


def _damping(scene: Scene, data: mujoco.MjData, spoil: Spoil) -> float:
    """Damping b over impedance of the taxels that hold the box, as it should be [1/s]."""
    link = touches(scene, data).links[0]
    body = scene.model.body(f"{HAND}{link}").id
    geom = int(np.flatnonzero((scene.model.geom_bodyid == body) & (scene.taxel >= 0))[0])
    return -float(scene.model.geom_solref[geom, 1]) / np.sqrt(spoil.stiffness) / PAD_IMPEDANCE
