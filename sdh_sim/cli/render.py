"""``sdh-sim render`` and ``sdh-sim view``: MuJoCo's own pictures, without a screen and on one."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.cli.show import check_writable, repeat, stored_jobs, write
from sdh_sim.errors import RenderError, RunError
from sdh_sim.runs import RunFolder

if TYPE_CHECKING:
    from sdh_sim.grasping import GraspPlan
    from sdh_sim.settings import TrialSettings

LEAST, MOST = 64, 4096  # pixels of a side
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")


def render(run: Path, trial: int, out: Path, size: tuple[int, int], azimuth: float) -> None:
    """Repeat a trial and write a picture of three moments, or a film of it all.

    Args:
        run: run folder.
        trial: its number.
        out: file ending in .png or .mp4.
        size: width and height in pixels.
        azimuth: of the camera about the object [deg].

    Raises:
        RunError: no such run or trial, an ending or a size that is not possible, or a file that
            cannot be written.
    """
    ending = out.suffix.lower()
    if ending not in (".png", ".mp4"):
        raise RunError(f"--out: got {out.name!r}; expected a name that ends in .png or .mp4")
    for option, side in zip(("--width", "--height"), size, strict=True):
        if not LEAST <= side <= MOST or side % 2:
            raise RunError(f"{option}: got {side}; expected an even number, {LEAST} to {MOST}")
    if not np.isfinite(azimuth):
        raise RunError(f"--azimuth: got {azimuth}; expected a finite angle in degrees")
    from sdh_sim.viewing.render import check_can_draw, film, render_trial, video_writer

    try:  # before the trial runs, not after
        check_can_draw()
        if ending == ".mp4":
            video_writer()
    except RenderError as error:
        raise RunError(str(error)) from error
    folder = RunFolder(run)
    ((job, row),) = stored_jobs(folder, [trial])
    check_writable("--out", out)
    log = repeat(folder, job, row)
    draw = render_trial if ending == ".png" else film
    write("--out", out, lambda: draw(log, out, size, azimuth))


def view(name: str, seed: int, grasps: Path | None = None, grasp: str | None = None) -> None:
    """Open MuJoCo's viewer on the cell of a trial, at its beginning, and wait until it closes.

    Args:
        name: of an object, or the path of a user's folder.
        seed: of the trial.
        grasps: file with the grasp; None draws one from the seed.
        grasp: its name in the file; None takes the first.

    Raises:
        RunError: no screen, no such grasp, or the arm cannot do it.
        SettingsError: no such object, a seed out of range, or a file that cannot be used.
    """
    from sdh_sim.objects import find_objects
    from sdh_sim.settings import TrialSettings

    if seed < 0:
        raise RunError(f"--seed: got {seed}; expected at least 0")
    names, folders = find_objects([name], {})
    if len(names) != 1:
        raise RunError(f"the viewer shows one object, got {name!r}; choose one of {names}")
    settings = TrialSettings(names[0], folder=folders.get(names[0]))
    plan = None if grasps is None else _given_plan(settings, grasps, grasp)
    if grasps is None and grasp is not None:
        raise RunError(f"--grasp: got {grasp!r:.80}; give the file that it is in as --grasps")
    if sys.platform == "linux" and not any(os.environ.get(screen) for screen in SCREENS):
        raise RunError(
            f"no screen for the viewer (none of {', '.join(SCREENS)} is set); draw a picture "
            "instead: sdh-sim render RUN --trial 0 --out trial.png"
        )
    import mujoco.viewer

    from sdh_sim.trial import Trial

    trial = Trial(settings, seed, plan=plan)
    trial.place()
    mujoco.viewer.launch(trial.scene.model, trial.simulation.data)


def _given_plan(settings: TrialSettings, file: Path, name: str | None) -> GraspPlan:
    """The plan of a grasp of a file, if the arm can do it; errors as ``view``."""
    from sdh_sim.cell import scene_of
    from sdh_sim.grasp_files import read_grasps
    from sdh_sim.grasping import Infeasible, plan_given, plan_of

    own = [e for e in read_grasps(file, [settings.object]) if name is None or e.name == name]
    if not own:
        raise RunError(f"--grasp: {file} has no {name!r:.80} for {settings.object}")
    scene = scene_of(settings)
    plan = plan_of(own[0], scene.obj)
    found = plan_given(scene, plan)
    if isinstance(found, Infeasible):
        raise RunError(f"{own[0].name} cannot be tried: {found.reason}; choose another --grasp")
    return plan
