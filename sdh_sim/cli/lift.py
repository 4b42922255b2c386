"""``sdh-sim lift``: from options to a plan, the progress bar, the closing table."""

from __future__ import annotations

import contextlib
import dataclasses
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
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

from sdh_sim.campaign import RunResult, paper_preset, run_campaign
from sdh_sim.campaign.campaign import OnStart, OnTrial
from sdh_sim.campaign.paper_preset import Share
from sdh_sim.cli.console import errors, output, plain_table
from sdh_sim.cli.lift_request import SEED, TRIALS, LiftRequest
from sdh_sim.errors import SettingsError
from sdh_sim.metrics import fault_lines, find_metrics
from sdh_sim.objects import find_objects, object_names
from sdh_sim.records import FAILURES, METRIC_ERROR, TrialRow, read_table
from sdh_sim.runs import RunFolder, RunPlan
from sdh_sim.settings import TrialSettings


def lift(request: LiftRequest) -> None:
    """Run the trials asked for with a progress bar, then print what came out."""
    if request.preset == "paper":
        lift_paper(request)
        return
    if request.preset == "fast":
        request = with_settings(request, paper_preset.FAST_SETTINGS)
    lift_round(request)


def lift_paper(request: LiftRequest) -> None:
    """Run trials until the paper's shares of stable and unstable grasps are full.

    Raises:
        SettingsError: objects or trials were given too, or a share cannot be filled.
    """
    if request.object or request.trials is not None:
        raise SettingsError("--preset paper decides objects and trials itself; leave both out")
    request = with_settings(request, paper_preset.PAPER_SETTINGS)
    request = dataclasses.replace(request, object=tuple(paper_preset.PAPER_SHARES))

    def run_round(trials: int, resume: bool) -> None:
        overwrite = request.options.overwrite and not resume
        options = dataclasses.replace(request.options, resume=resume, overwrite=overwrite)
        lift_round(dataclasses.replace(request, trials=trials, options=options))

    def on_round(found: Mapping[str, Share], trials: int) -> None:
        errors().print(f"{_state_of(found)}: on to {trials} trials of each", soft_wrap=True)

    folder = RunFolder(request.out)
    found = paper_preset.fill_shares(folder, request.options.resume, run_round, on_round)
    output().print(_state_of(found), soft_wrap=True)
    paper_preset.check_full(found)


def with_settings(request: LiftRequest, preset: Mapping[str, Any]) -> LiftRequest:
    """The request with a preset's settings where it gives none of its own."""
    return dataclasses.replace(request, settings={**preset, **request.settings})


def _state_of(found: Mapping[str, Share]) -> str:
    parts = (f"{n} {s.stable} held, {s.unstable} not (of {s.wanted})" for n, s in found.items())
    return "shares: " + "; ".join(parts)


def lift_round(request: LiftRequest) -> None:
    """Run one plan, whatever the preset."""
    folder = RunFolder(request.out)
    stored = folder.read_plan() if request.options.resume and folder.holds_run() else None
    plan = make_plan(request, stored)
    if stored is not None and plan.trials > stored.trials and len(plan.objects) > 1:
        errors().print(
            f"note: trial numbers move, each object now has {plan.trials} in a row (it had "
            f"{stored.trials})",
            soft_wrap=True,
        )
    options = dataclasses.asdict(request.options)
    with _progress(plan) as (on_start, on_trial):
        result = run_campaign(plan, request.out, **options, on_start=on_start, on_trial=on_trial)
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


def make_plan(request: LiftRequest, stored: RunPlan | None) -> RunPlan:
    """The plan of the request; what it leaves out is the stored plan's, or the default."""
    if not request.object and stored is None:
        raise SettingsError(
            f"object: missing; give one of {', '.join(object_names())}, or all, or the path of a "
            "folder with an object of your own"
        )
    before = {} if stored is None else stored.folders
    objects = request.object or (() if stored is None else stored.objects)
    names, folders = find_objects(objects, before)
    metrics = find_metrics(request.metric, () if stored is None else stored.settings.metrics)
    given = {"object": names[0], "metrics": metrics, **request.settings}
    if stored is None:
        settings, trials, seed = TrialSettings(**given), TRIALS, SEED
    else:
        settings = dataclasses.replace(stored.settings, **given)
        trials, seed = stored.trials, stored.seed
    return RunPlan(
        names,
        settings,
        trials if request.trials is None else request.trials,
        seed if request.seed is None else request.seed,
        folders,
    )


@contextlib.contextmanager
def _progress(plan: RunPlan) -> Iterator[tuple[OnStart, OnTrial]]:
    """A bar on a terminal, a line at every tenth of the run elsewhere; both on stderr.

    Yields what takes the count of earlier sessions and what takes each new row.
    """
    console = errors()
    done = Counter[bool]()

    def start(result: RunResult) -> None:
        for failure, count in result.failures().items():
            done[failure == "none"] += count

    if not console.is_terminal:

        def count(row: TrialRow) -> None:
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

        def advance(row: TrialRow) -> None:
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
