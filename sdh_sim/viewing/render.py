"""Pictures and films of trials by MuJoCo's own renderer, without a screen."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np
from PIL import Image

from sdh_sim import graphics
from sdh_sim.atomic_files import atomic_file
from sdh_sim.errors import RenderError, one_line
from sdh_sim.trial import TrialLog
from sdh_sim.trial.trial_log import RATE

SIZE = (960, 720)
AZIMUTH = 125.0  # [deg]
LOOK_OFFSET = np.array([0.0, 0.0, 0.02])


def draw_frames(
    log: TrialLog,
    indices: Iterable[int],
    size: tuple[int, int] = SIZE,
    azimuth: float = AZIMUTH,
    distance: float = 0.85,
    shadows: bool = True,
) -> Iterator[np.ndarray]:
    """Pictures (height, width, 3) uint8 of the given samples of a log, one after the other.

    Args:
        log: a trial's log.
        indices: samples to draw.
        size: width and height in pixels.
        azimuth: of the camera about the object [deg].
        distance: of the camera from the object [m].
        shadows: drawn too; without a graphics card a picture then takes four times as long.

    Raises:
        RenderError: neither EGL nor OSMesa works here.
    """
    model = log.scene.model
    data = mujoco.MjData(model)
    width, height = size
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    renderer = renderer_of(model, width, height)
    camera = mujoco.MjvCamera()
    camera.distance, camera.azimuth, camera.elevation = distance, azimuth, -18.0
    options = mujoco.MjvOption()
    options.geomgroup[:] = (1, 1, 1, 0, 0, 0)  # no collision shapes, no taxel spheres
    options.sitegroup[:] = 0
    with renderer:
        for index in indices:
            data.qpos[:] = log.qpos[index]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            camera.lookat[:] = 0.5 * (data.xpos[log.scene.object_body] + data.xpos[log.scene.palm])
            camera.lookat[:] += LOOK_OFFSET
            renderer.update_scene(data, camera, options)
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
            renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = shadows
            yield renderer.render().copy()


def check_can_draw() -> None:
    """Raise RenderError where ``MUJOCO_GL`` rules out every picture."""
    if (reason := graphics.why_nothing_can_be_drawn()) is not None:
        raise RenderError(f"nothing can be drawn: {reason}")


def renderer_of(model: mujoco.MjModel, width: int, height: int) -> mujoco.Renderer:
    """A renderer without a screen; raises RenderError where there can be none."""
    check_can_draw()
    try:
        return mujoco.Renderer(model, height, width)
    except Exception as error:  # the back ends raise errors of many types, some without a text
        try:
            text = f"{type(error).__name__}: {one_line(error)}"
        except Exception:
            text = type(error).__name__
        raise RenderError(
            f"no headless OpenGL ({text}); install EGL (Debian: libegl1 libgl1-mesa-dri) or "
            "OSMesa (libosmesa6), and unset MUJOCO_GL, or set it to egl or osmesa"
        ) from error


def milestones(log: TrialLog) -> list[int]:
    """Indices of the samples at the pre-grasp, the snapshot and the end."""
    phases = np.array(log.phase)
    chosen = []
    for phase in ("approach", "rest"):
        hits = np.flatnonzero(phase == phases)
        if len(hits):
            chosen.append(int(hits[-1]))
    chosen.append(len(phases) - 1)
    return chosen


def render_trial(
    log: TrialLog, path: Path, size: tuple[int, int] = (720, 640), azimuth: float = AZIMUTH
) -> None:
    """Write one PNG: pre-grasp, snapshot and end of a trial side by side.

    Raises:
        RenderError: no headless OpenGL here.
        OSError: the file cannot be written.
    """
    frames = list(draw_frames(log, milestones(log), size, azimuth))
    with atomic_file(path) as file:
        Image.fromarray(np.hstack(frames)).save(file, format="PNG")


def video_writer() -> ModuleType:
    """The module PyAV, which writes films.

    Raises:
        RenderError: it is not installed.
    """
    try:
        import av
    except ImportError as error:
        raise RenderError('films need PyAV: pip install "sdh-sim[video]"') from error
    return av


def film(log: TrialLog, path: Path, size: tuple[int, int] = SIZE, azimuth: float = AZIMUTH) -> None:
    """Write an MP4 (H.264) of a whole trial, in real time.

    Raises:
        RenderError: no headless OpenGL here, or no PyAV.
        OSError: the file cannot be written.
    """
    av = video_writer()
    with atomic_file(path) as file, av.open(file, mode="w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=round(RATE))
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        samples = range(len(log.time))
        for picture in draw_frames(log, samples, size, azimuth, shadows=False):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
