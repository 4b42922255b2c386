"""``sdh-sim lift``: from options to a plan, the progress bar, the closing table."""

from __future__ import annotations

import contextlib
import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from sdh_sim.campaign import paper_preset as preset
from sdh_sim.campaign.campaign import OnTrial, default_workers, run_campaign
from sdh_sim.campaign.session import RunResult
from sdh_sim.cli.console import errors, output, plain_table
from sdh_sim.errors import SettingsError
from sdh_sim.metrics.user_metrics import fault_lines, find_metrics
from sdh_sim.objects.catalogue import find_objects, object_names
from sdh_sim.records.parquet_files import read_rows, read_table, write_rows
from sdh_sim.records.rows import Row
from sdh_sim.records.trial_row import FAILURES
from sdh_sim.records.user_columns import METRIC_ERROR, added_columns
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.plan import RunPlan
from sdh_sim.settings import TrialSettings

TRIALS = 20
SEED = 0
_OUTCOME = ("object", "success", "failure")


@dataclass(frozen=True)
class Asked:
    """What the command line gave; what it left out is empty or None.

    Attributes:
        objects: names, "all", or paths of folders.
        trials: trials per object.
        seed: seed of the run.
        settings: fields of TrialSettings.
        metrics: users' metrics: module:function, file.py:function or an entry point.
    """

    objects: tuple[str, ...]
    trials: int | None
    seed: int | None
    settings: Mapping[str, Any]
    metrics: tuple[str, ...] = ()


def lift(
    out: str | Path,
    asked: Asked,
    *,
    workers: int | None = None,
    rerun: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    retry_errors: bool = False,
    executor: str | None = None,
    scheduler: str | None = None,
    command: str = "",
) -> None:
    """Run the trials asked for with a progress bar, then print what came out."""
    folder = RunFolder(out)
    stored = folder.read_plan() if resume and folder.holds_run() else None
    plan = make_plan(asked, stored)
    if stored is not None and plan.trials > stored.trials and len(plan.objects) > 1:
        errors().print(
            f"note: trial numbers move, each object now has {plan.trials} in a row (it had "
            f"{stored.trials})",
            soft_wrap=True,
        )
    with _progress(plan) as (on_start, on_trial):
        result = run_campaign(
            plan,
            out,
            default_workers() if workers is None else workers,
            resume=resume,
            overwrite=overwrite,
            retry_errors=retry_errors,
            rerun=rerun or "none",
            executor=executor or "processes",
            scheduler=scheduler,
            on_start=on_start,
            on_trial=on_trial,
            command=command,
        )
    output().print(summary(plan.objects, result))
    output().print(f"table: {folder.table}", soft_wrap=True, markup=False, highlight=False)
    if plan.settings.metrics:
        faults = read_table(folder.table, [METRIC_ERROR]).column(0).to_pylist()
        for line in fault_lines(faults, len(faults)):
            errors().print(f"warning: {line}", soft_wrap=True, markup=False, highlight=False)
    if failed := result.failures()["error"]:
        errors().print(
            f"note: {failed} trials ended as error, see {folder.errors}; run them again with: "
            f"{folder.resume_command} --retry-errors",
            soft_wrap=True,
            markup=False,
        )


def lift_preset(name: str | None, out: str | Path, asked: Asked, **options: Any) -> None:
    """``lift`` with a preset's settings below the ones asked for; None is plain ``lift``."""
    if name is None:
        lift(out, asked, **options)
    elif name == "paper":
        lift_paper(out, asked, **options)
    elif name == "fast":
        settings = {**preset.FAST_SETTINGS, **asked.settings}
        lift(out, dataclasses.replace(asked, settings=settings), **options)
    else:
        raise SettingsError(f"preset: got {name!r}; choose one of paper, fast")


def lift_paper(out: str | Path, asked: Asked, **options: Any) -> None:
    """Run trials until the paper's shares of stable and unstable grasps are full.

    Args:
        out: folder of the run.
        asked: seed and settings, on top of the preset's; objects and trials are the paper's.
        options: as for ``lift``.

    Raises:
        SettingsError: objects or trials were given too, or a share cannot be filled.
    """
    if asked.objects or asked.trials is not None:
        raise SettingsError("--preset paper decides objects and trials itself; leave both out")
    folder = RunFolder(out)
    trials = preset.FIRST
    if options.get("resume") and folder.holds_run():
        trials = max(trials, folder.read_plan().trials)
    settings = {**preset.PAPER_SETTINGS, **asked.settings}
    while True:
        names = tuple(preset.PAPER_SHARES)
        lift(
            out,
            dataclasses.replace(asked, objects=names, trials=trials, settings=settings),
            **options,
        )
        options = {**options, "resume": True, "overwrite": False}
        found = preset.shares(read_table(folder.table, _OUTCOME).to_pylist())
        needed = preset.trials_needed(found, trials)
        if needed == trials:
            break
        errors().print(f"{_state_of(found)}: on to {needed} trials of each", soft_wrap=True)
        trials = needed
    added = added_columns(folder.read_plan().settings.metrics)
    write_rows(preset.mark_surplus(read_rows(folder.table)), folder.table, added)
    output().print(_state_of(found), soft_wrap=True)
    short = [name for name, share in found.items() if not share.full]
    if short:
        raise SettingsError(
            f"preset: {', '.join(short)} cannot fill the paper's share in {preset.MOST} trials; "
            "all that ran is kept; try other settings"
        )


def _state_of(found: Mapping[str, preset.Share]) -> str:
    parts = (f"{n} {s.stable} held, {s.unstable} not (of {s.wanted})" for n, s in found.items())
    return "shares: " + "; ".join(parts)


def make_plan(asked: Asked, stored: RunPlan | None) -> RunPlan:
    """The plan of the options; what they leave out is the stored plan's, or the default."""
    if not asked.objects and stored is None:
        raise SettingsError(
            f"object: missing; give one of {', '.join(object_names())}, or all, or the path of a "
            "folder with an object of your own"
        )
    before = {} if stored is None else stored.folders
    objects = asked.objects or (() if stored is None else stored.objects)
    names, folders = find_objects(objects, before)
    metrics = find_metrics(asked.metrics, () if stored is None else stored.settings.metrics)
    given = {"object": names[0], "metrics": metrics, **asked.settings}
    if stored is None:
        settings = TrialSettings(**given)
    else:
        settings = dataclasses.replace(stored.settings, **given)
    trials = asked.trials if asked.trials is not None else (stored.trials if stored else TRIALS)
    seed = asked.seed if asked.seed is not None else (stored.seed if stored else SEED)
    return RunPlan(names, settings, trials, seed, folders)


@contextlib.contextmanager
def _progress(plan: RunPlan) -> Iterator[tuple[Callable[[RunResult], None], OnTrial]]:
    """A bar on a terminal, a line at every tenth of the run elsewhere; both on stderr.

    Yields what takes the count of earlier sessions and what takes each new row.
    """
    console = errors()
    done = Counter[bool]()

    def start(result: RunResult) -> None:
        for failure, count in result.failures().items():
            done[failure == "none"] += count

    if not console.is_terminal:

        def count(row: Row) -> None:
            done[row["success"]] += 1
            total = done.total()
            if total * 10 // plan.total > (total - 1) * 10 // plan.total:
                console.print(f"{total}/{plan.total} trials, {done[True]} succeeded")

        yield start, count
        return

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[succeeded]} succeeded"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
    )
    with bar:
        task = bar.add_task("trials", total=plan.total, succeeded=0)

        def advance(row: Row) -> None:
            done[row["success"]] += 1
            bar.update(task, completed=done.total(), succeeded=done[True])

        yield start, advance


def summary(objects: Iterable[str], result: RunResult) -> Table:
    """Per object: trials, successes, simulated seconds per worker second, how trials failed."""
    table = plain_table("object", "trials", "success", "sim s / wall s", "failures", text=(0, 4))
    names = list(objects)
    for name in names:
        table.add_row(name, *_summary_cells(result, [name]))
    if len(names) > 1:
        table.add_section()
        table.add_row("all", *_summary_cells(result, names))
    return table


def _summary_cells(result: RunResult, objects: list[str]) -> list[str]:
    modes = result.failures(*objects)
    total, good = modes.total(), modes["none"]
    share = f"{good} ({100 * good / total:.0f} %)" if total else "-"
    named = [f"{mode} {modes[mode]}" for mode in FAILURES if mode != "none" and modes[mode]]
    simulated = sum(result.sim_seconds.get(name, 0.0) for name in objects)
    wall = sum(result.wall_seconds.get(name, 0.0) for name in objects)
    speed = f"{simulated / wall:.1f}" if wall > 0 else "-"
    return [str(total), share, speed, ", ".join(named) or "-"]
