"""``sdh-sim show``: run one trial of a run again, check that it is the same, look at it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sdh_sim import records
from sdh_sim.cli_console import errors, output
from sdh_sim.columns import is_added
from sdh_sim.run_folder import RunError, RunFolder, versions


def show(
    run: Path,
    trial: int,
    save: Path | None = None,
    png: Path | None = None,
) -> None:
    """Repeat the trial, then write its recording or picture; with neither, open the viewer.

    Args:
        run: run folder.
        trial: number of the trial.
        save: file of the rerun recording.
        png: file of the picture.

    Raises:
        RunError: no such run or trial, or a file that cannot be written.
    """
    folder = RunFolder(run)
    plan = folder.read_plan()
    job = plan.job(trial)
    rows = folder.read_rows(plan)
    if trial not in rows:
        raise RunError(
            f"trial {trial} of {run} has not run yet ({len(rows)} of {plan.total} have); "
            f"continue with: {folder.resume_command}"
        )
    for option, path in (("--save", save), ("--png", png)):
        if path is not None:
            _check_writable(option, path)

    from sdh_sim.trial import run_trial

    # Users' metrics are not evaluated again: code that a run's folder names is not run unasked.
    settings = dataclasses.replace(job.settings, metrics=())
    result = run_trial(settings, job.seed, log=True)
    log: Any = result.log
    row = records.normalise({**result.row, "trial": trial})
    row["surplus"] = rows[trial]["surplus"]  # known to the run, not to the trial
    row |= {name: value for name, value in rows[trial].items() if is_added(name)}
    if differing := records.differing_columns(row, rows[trial]):
        _warn(folder, differing)
    output().print(verdict(row), markup=False, soft_wrap=True)
    if save is not None:
        from sdh_sim.recording import write_recording

        _write("--save", save, lambda: write_recording(log, save))
    if png is not None:
        from sdh_sim.render import render_trial

        _write("--png", png, lambda: render_trial(log, png))
    if save is None and png is None:
        from sdh_sim.recording import spawn_viewer

        spawn_viewer(log)


def _check_writable(option: str, path: Path) -> None:
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


def _write(option: str, path: Path, write: Callable[[], object]) -> None:
    try:
        write()
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


def verdict(row: records.Row) -> str:
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
