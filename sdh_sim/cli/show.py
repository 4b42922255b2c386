"""``sdh-sim show``: run trials of a run again, check that they are the same, look at them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from sdh_sim.cli.console import errors, output
from sdh_sim.errors import RenderError, RunError
from sdh_sim.records import TrialRow, differing_columns, is_added, normalise
from sdh_sim.runs import RunFolder, read_given_grasps, versions, with_grasp


def show(
    run: Path,
    trials: Sequence[int],
    save: Path | None = None,
    png: Path | None = None,
) -> None:
    """Repeat trials, then write their recording or a picture; with neither, open the viewer.

    Args:
        run: run folder.
        trials: their numbers; a picture takes one.
        save: file of the rerun recording.
        png: file of the picture.

    Raises:
        RunError: no such run or trial, or a file that cannot be written.
    """
    folder = RunFolder(run)
    jobs = stored_jobs(folder, trials)
    if png is not None and len(jobs) > 1:
        raise RunError(f"--png shows one trial, got {len(jobs)}; give one --trial")
    for option, path in (("--save", save), ("--png", png)):
        if path is not None:
            check_writable(option, path)
    logs = (repeat(folder, job, row) for job, row in jobs)
    if save is not None:
        from sdh_sim.viewing.recording import write_recordings

        # A generator: one trial's log is in memory at a time.
        kept: list[Any] = []
        write("--save", save, lambda: write_recordings(_keeping(logs, kept), save))
        logs = iter(kept)
    if png is not None:
        from sdh_sim.viewing.render import render_trial

        write("--png", png, lambda: render_trial(next(logs), png))
    if save is None and png is None:
        from sdh_sim.viewing.recording import spawn_viewer

        for log in logs:
            spawn_viewer(log)


def _keeping(logs: Iterable[Any], kept: list[Any]) -> Iterator[Any]:
    """The logs, of which the first is kept for a picture."""
    for log in logs:
        if not kept:
            kept.append(log)
        yield log


def stored_jobs(folder: RunFolder, trials: Sequence[int]) -> list[tuple[Any, TrialRow]]:
    """The jobs of trials that have run, each once, with their rows of the table.

    Raises:
        RunError: no such run or trial, it has not run yet, or its grasp is infeasible.
        GraspFileError: the run's file of grasps is missing or has changed.
    """
    plan = folder.read_plan()
    given = read_given_grasps(plan)
    jobs = [with_grasp(plan.job(trial), given) for trial in dict.fromkeys(trials)]
    rows = folder.read_rows(plan)
    for job in jobs:
        if job.trial not in rows:
            raise RunError(
                f"trial {job.trial} of {folder.path} has not run yet ({len(rows)} of {plan.total} "
                f"have); continue with: {folder.resume_command}"
            )
        if rows[job.trial]["failure"] == "infeasible":
            raise RunError(
                f"trial {job.trial} of {folder.path} has nothing to show, its grasp is infeasible: "
                f"{rows[job.trial]['infeasible_reason']}; choose another trial"
            )
    return [(job, rows[job.trial]) for job in jobs]


def repeat(folder: RunFolder, job: Any, stored: TrialRow) -> Any:
    """Run a stored trial again, print its verdict, and warn where it differs; its log."""
    log, row = run_again(job, stored)
    if differing := differing_columns(row, stored):
        _warn(folder, differing)
    output().print(verdict(row), markup=False, soft_wrap=True)
    return log


def run_again(job: Any, stored: TrialRow) -> tuple[Any, TrialRow]:
    """Run a stored trial again: its log, and its row as the run would have written it."""
    from sdh_sim.campaign.jobs import given_plan
    from sdh_sim.trial import run_trial

    # Users' metrics are not evaluated again: code that a run's folder names is not run unasked.
    settings = dataclasses.replace(job.settings, metrics=())
    result = run_trial(settings, job.seed, log=True, **given_plan(job))
    row = normalise({**result.row, **job.labels})
    row["surplus"] = stored["surplus"]  # known to the run, not to the trial
    row.update({name: value for name, value in stored.items() if is_added(name)})
    return result.log, row


def check_writable(option: str, path: Path) -> None:
    """Find out before the trial runs, not after."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        new = not path.exists()
        with open(path, "ab"):
            pass
        if new:
            path.unlink()
    except OSError as error:
        raise _refused(option, path, error) from error


def write(option: str, path: Path, write: Callable[[], object]) -> None:
    try:
        write()
    except RenderError as error:
        raise RunError(str(error)) from error
    except OSError as error:
        raise _refused(option, path, error) from error
    output().print(f"{path}", markup=False, soft_wrap=True)


def _refused(option: str, path: Path, error: OSError) -> RunError:
    return RunError(f"cannot write {path}: {error.strerror or error}; choose another {option}")


def _warn(folder: RunFolder, differing: list[str]) -> None:
    line = f"warning: the repeated trial differs from the stored one in {', '.join(differing)}"
    if changed := _changed_versions(folder):
        line += f" (since the run: {', '.join(changed)})"
    errors().print(line, markup=False, soft_wrap=True)


def _changed_versions(folder: RunFolder) -> list[str]:
    sessions = folder.read_info().get("sessions")
    last = sessions[-1] if isinstance(sessions, list) and sessions else {}
    then = last.get("versions") if isinstance(last, dict) else {}
    now = versions()
    if not isinstance(then, dict):
        return []
    return [f"{k} {then[k]} is now {now[k]}" for k in now if then.get(k, now[k]) != now[k]]


def verdict(row: TrialRow) -> str:
    """One line: what happened and what was predicted."""
    outcome = "held" if row["success"] else row["failure"]
    return (
        f"trial {row['trial']}: {row['object']}, seed {row['seed']}: {outcome} "
        f"(displacement {_number(row['displacement_mm'], 'mm')}, "
        f"rotation {_number(row['rotation_deg'], 'deg')}); "
        f"q* L∞ {_number(row['q_linf'])}, q* L1 {_number(row['q_l1'])}"
    )


def _number(value: float | None, unit: str = "") -> str:
    return "-" if value is None else f"{value:.2f} {unit}".rstrip()
