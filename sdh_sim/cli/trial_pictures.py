"""What a report needs to know of its runs: the command that shows a trial, and pictures of some."""

from __future__ import annotations

import io
import shlex
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sdh_sim.analysis.cases import Case
from sdh_sim.cli.console import output
from sdh_sim.cli.show import run_again, stored_jobs
from sdh_sim.errors import NoFeasibleGrasp, RecordError, RenderError, RunError, SettingsError
from sdh_sim.report.look import Look
from sdh_sim.runs import RunFolder

SIZE = (320, 280)  # pixels of each of a picture's three moments
QUALITY = 85  # of JPEG
SUGGESTED = 6  # pictures


def look_at(runs: Sequence[Path], pictures: int) -> Look:
    """How to look at the trials of some runs.

    Args:
        runs: folders, or files of trials, in the order in which they were read.
        pictures: how many of the worst mispredictions are to be run again and drawn.
    """
    folders = [run for run in runs if run.is_dir()]
    hint = ""
    if folders and not pictures:
        given = " ".join(shlex.quote(str(run)) for run in runs)
        hint = (
            "Their pictures need the trials run again, some seconds each: "
            f"sdh-sim compare {given} --pictures {SUGGESTED}."
        )
    return Look(
        command=lambda case: command(runs[case.source], case),
        names=tuple(run.resolve().name for run in runs),
        photograph=Photographer(runs),
        photographs=pictures,
        hint=hint,
    )


def command(run: Path, case: Case) -> str:
    """The command that shows a trial; empty for one of a bare file, which cannot be run again."""
    return f"sdh-sim show {shlex.quote(str(run))} --trial {case.trial}" if run.is_dir() else ""


class Photographer:
    """Runs trials again and takes their pictures; once there is no graphics, it runs none."""

    def __init__(self, runs: Sequence[Path]) -> None:
        self.runs = runs
        self.no_graphics = ""

    def __call__(self, case: Case) -> bytes | str:
        """The three moments of a trial side by side as JPEG, or why there are none, in a line."""
        run = self.runs[case.source]
        if not run.is_dir():
            return f"{run.name} is a table alone; give the folder of its run"
        if self.no_graphics:
            return self.no_graphics
        output().print(f"drawing trial {case.trial} of {run}", markup=False, soft_wrap=True)
        try:
            return _photograph(RunFolder(run), case.trial)
        except RenderError as error:
            self.no_graphics = _line(error)
            return self.no_graphics
        except (SettingsError, RunError, RecordError, NoFeasibleGrasp, OSError) as error:
            return _line(error)


def _line(error: Exception) -> str:
    return " ".join(str(error).split())


def _photograph(folder: RunFolder, trial: int) -> bytes:
    from PIL import Image

    from sdh_sim.viewing.render import draw_frames, milestones

    ((job, stored),) = stored_jobs(folder, [trial])
    log, row = run_again(job, stored)
    if (row["failure"], row["q_linf"]) != (stored["failure"], stored["q_linf"]):
        raise RunError("run again it went otherwise; has something changed since the run?")
    # Without shadows: half the time without a graphics card.
    frames = draw_frames(log, milestones(log), SIZE, shadows=False)
    file = io.BytesIO()
    Image.fromarray(np.hstack(list(frames))).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()
