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
from sdh_sim.cli.lift_plan import grasp_file, make_plan
from sdh_sim.cli.lift_request import LiftRequest
from sdh_sim.errors import SettingsError
from sdh_sim.metrics import fault_lines
from sdh_sim.records import FAILURES, METRIC_ERROR, TrialRow, read_table
from sdh_sim.runs import RunFolder, RunPlan


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
    if grasp_file(request) is not None:
        raise SettingsError("--preset paper draws its grasps itself; leave --grasps out")
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
            f"note: trial numbers move, each {'grasp' if plan.grasp_counts else 'object'} now has "
            f"{plan.trials} trials (it had {stored.trials})",
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
    """Per object: trials, successes, simulated seconds per worker second, how trials failed.

    Grasps of a file that could not be tried are no failures: they have a column of their own, if
    there are any, and no part in the share of successes.
    """
    apart = bool(result.failures()["infeasible"])
    head = ["object", "trials", *(["infeasible"] if apart else []), "success", "sim s / wall s"]
    table = plain_table(*head, "failures", text=(0, len(head)))
    names = list(objects)
    for name in names:
        table.add_row(name, *_summary_cells(result, [name], apart))
    if len(names) > 1:
        table.add_section()
        table.add_row("all", *_summary_cells(result, names, apart))
    return table


def _summary_cells(result: RunResult, objects: list[str], apart: bool) -> list[str]:
    modes = result.failures(*objects)
    total, good, untried = modes.total(), modes["none"], modes["infeasible"]
    tried = total - untried
    share = f"{good} ({100 * good / tried:.0f} %)" if tried else "-"
    others = [mode for mode in FAILURES if mode not in ("none", "infeasible") and modes[mode]]
    simulated = sum(result.sim_seconds.get(name, 0.0) for name in objects)
    wall = sum(result.wall_seconds.get(name, 0.0) for name in objects)
    speed = f"{simulated / wall:.1f}" if wall > 0 else "-"
    named = ", ".join(f"{mode} {modes[mode]}" for mode in others) or "-"
    return [str(total), *([str(untried)] if apart else []), share, speed, named]
