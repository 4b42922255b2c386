"""Pictures of trials by MuJoCo's own renderer, without a screen."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from PIL import Image

from sdh_sim.log import TrialLog

SIZE = (960, 720)
LOOK_OFFSET = np.array([0.0, 0.0, 0.02])


class RenderError(OSError):
    """No headless OpenGL on this machine; the message names the package that helps."""


def render_frames(
    log: TrialLog,
    indices: list[int],
    size: tuple[int, int] = SIZE,
    azimuth: float = 125.0,
    distance: float = 0.85,
) -> list[np.ndarray]:
    """Pictures (height, width, 3) uint8 of the given samples of a log.

    Args:
        log: a trial's log.
        indices: samples to draw.
        size: width and height in pixels.
        azimuth: of the camera about the object [deg].
        distance: of the camera from the object [m].

    Raises:
        RenderError: neither EGL nor OSMesa works here.
    """
    model = log.scene.model
    data = mujoco.MjData(model)
    width, height = size
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    try:
        renderer = mujoco.Renderer(model, height, width)
    except Exception as error:  # the backends raise what they like
        raise RenderError(
            f"no headless OpenGL ({type(error).__name__}: {error}); install EGL "
            "(Debian: libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6, with MUJOCO_GL=osmesa)"
        ) from error
    camera = mujoco.MjvCamera()
    camera.distance, camera.azimuth, camera.elevation = distance, azimuth, -18.0
    options = mujoco.MjvOption()
    options.geomgroup[:] = (1, 1, 1, 0, 0, 0)  # no collision shapes, no taxel spheres
    options.sitegroup[:] = 0
    frames = []
    with renderer:
        for index in indices:
            data.qpos[:] = log.qpos[index]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            camera.lookat[:] = 0.5 * (data.xpos[log.scene.object] + data.xpos[log.scene.palm])
            camera.lookat[:] += LOOK_OFFSET
            renderer.update_scene(data, camera, options)
            frames.append(renderer.render().copy())
    return frames


def milestones(log: TrialLog) -> list[int]:
    """Samples at the pre-grasp, the snapshot and the end."""
    phases = np.array(log.phase)
    chosen = []
    for phase in ("approach", "rest"):
        hits = np.flatnonzero(phase == phases)
        if len(hits):
            chosen.append(int(hits[-1]))
    chosen.append(len(phases) - 1)
    return chosen


def render_trial(log: TrialLog, path: Path, size: tuple[int, int] = (720, 640)) -> None:
    """Write one PNG: pre-grasp, snapshot and end of a trial side by side.

    Raises:
        RenderError: no headless OpenGL here.
        OSError: the file cannot be written.
    """
    frames = render_frames(log, milestones(log), size)
    Image.fromarray(np.hstack(frames)).save(path, format="PNG")
