"""A run of many trials: every finished one kept at once, an orderly stop, a way to go on."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from sdh_sim import records
from sdh_sim.campaign.jobs import Executor, TrialFunction, Work, run_jobs
from sdh_sim.campaign.session import Keeper, RunResult
from sdh_sim.campaign.stop_signals import StopSignals
from sdh_sim.errors import CampaignError, Interrupted, RunError, SettingsError
from sdh_sim.runs.environment import versions
from sdh_sim.runs.finished_trials import TrialStore
from sdh_sim.runs.folder import RunFolder
from sdh_sim.runs.lock import run_lock
from sdh_sim.runs.plan import RunPlan

__all__ = [
    "CampaignError",
    "Interrupted",
    "OnTrial",
    "RunResult",
    "default_workers",
    "run_campaign",
]

RERUN = ("all", "failures", "none")
EXECUTORS = ("processes", "dask")

OnTrial = Callable[[records.Row], None]


def default_workers() -> int:
    """One worker per core that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_campaign(
    plan: RunPlan,
    out: str | Path,
    workers: int = 1,
    *,
    resume: bool = False,
    overwrite: bool = False,
    retry_errors: bool = False,
    rerun: str = "none",
    executor: str = "processes",
    scheduler: str | None = None,
    on_start: Callable[[RunResult], None] | None = None,
    on_trial: OnTrial | None = None,
    command: str = "",
    save_every: float = 5.0,
    trial: TrialFunction | None = None,
) -> RunResult:
    """Run the trials that the folder lacks and keep each as soon as it has finished.

    The table's bytes depend on the plan alone: not on where trials run or how many at a time, nor
    on interruptions. A trial that raises, or whose process dies, is run once more and then is a
    row with the failure ``error``, its traceback in ``errors/``; the run goes on.

    Worker processes import the calling script anew: it must start the run below ``if __name__ ==
    "__main__":``, as Python's multiprocessing asks.

    Args:
        plan: what to run; with ``resume`` it may ask for more trials than the run had.
        out: folder of the run.
        workers: number of processes; a cluster (``scheduler``) has its own.
        resume: continue the run in ``out`` (a folder without a run starts one).
        overwrite: replace the run in ``out``.
        retry_errors: with ``resume``, run trials that ended as ``error`` again.
        rerun: which trials leave a rerun recording: ``all``, ``failures`` or ``none``.
        executor: what runs trials: ``processes``, or ``dask`` (the extra ``distributed``).
        scheduler: for ``dask``: address of a running scheduler, or its scheduler file; None starts
            a scheduler and ``workers`` processes on this machine.
        on_start: called once with what earlier sessions finished.
        on_trial: called with each row of this session when it is on the disk.
        command: command line to keep in ``run.json``.
        save_every: shortest time between two writes of the table while the run goes on [s].
        trial: what runs one trial: ``sdh_sim.trial.run_trial``, or a module-level stand-in.

    Raises:
        RunError, SettingsError: the folder or an argument cannot be used; nothing was changed.
        Interrupted: Ctrl-C or SIGTERM; finished trials are kept.
        CampaignError: the disk refused, no worker starts or every trial fails; finished trials
            are kept.
    """
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise SettingsError(f"workers: got {workers!r}; give a whole number of at least 1")
    if rerun not in RERUN:
        raise SettingsError(f"rerun: got {rerun!r}; choose one of {', '.join(RERUN)}")
    if executor not in EXECUTORS:
        raise SettingsError(f"executor: got {executor!r}; choose one of {', '.join(EXECUTORS)}")
    if scheduler is not None and executor != "dask":
        raise SettingsError(f"scheduler: got {scheduler!r}; it needs --executor dask")
    if resume and overwrite:
        raise SettingsError("--resume and --overwrite exclude each other; give one of them")
    if retry_errors and not resume:
        raise SettingsError("--retry-errors continues a run; give --resume with it")
    if executor == "dask":
        from sdh_sim.campaign import (
            dask_cluster as cluster,  # raises SettingsError where the extra is missing
        )

        cluster.check(scheduler)
    folder = RunFolder(out)
    folder.make()
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(run_lock(folder.lock))
        except OSError as error:
            raise folder.write_error(error) from error
        keeper = _open(plan, folder, resume, overwrite, retry_errors)
        if on_start is not None:
            on_start(keeper.result)
        todo = plan.total - keeper.store.kept
        workers = min(workers, max(todo, 1))
        keeper.begin(command, workers, rerun, executor)
        stop = stack.enter_context(StopSignals())
        broken_by: BaseException | None = None
        try:
            if todo:
                work = Work(trial, rerun, folder, versions() if scheduler is not None else None)
                runs = _executor(executor, workers, work, scheduler)
                jobs = (plan.job(int(n)) for n in _missing(keeper.store))
                with contextlib.closing(run_jobs(jobs, runs)) as outcomes:
                    for batch in outcomes:
                        with stop.held():
                            rows = keeper.add(batch)
                        if on_trial is not None:
                            for row in rows:
                                on_trial(row)
                        keeper.save_if_due(save_every)
                keeper.check_hope()
        except BaseException as error:
            broken_by = error
        stop.ignore_further()
        keeper.close(broken_by)
    return keeper.result


def _missing(store: TrialStore) -> Iterator[int]:
    # Looked up as they are needed: a list of a million numbers would be the largest thing here.
    return (number for number in range(len(store.done)) if not store.done[number])


def _executor(name: str, workers: int, work: Work, scheduler: str | None) -> Executor:
    if name == "dask":
        from sdh_sim.campaign.dask_cluster import DaskExecutor

        return DaskExecutor(workers, work, scheduler)
    from sdh_sim.campaign.local_processes import ProcessExecutor

    return ProcessExecutor(workers, work)


def _open(
    plan: RunPlan, folder: RunFolder, resume: bool, overwrite: bool, retry_errors: bool
) -> Keeper:
    sessions: list[dict[str, Any]] = []
    if resume and folder.holds_run():
        stored = folder.read_plan()
        if changes := plan.changes_from(stored):
            raise RunError(
                f"{folder.path} was run with other settings: {'; '.join(changes)}; resume with the "
                "run's own (leave the option out), or choose another --out"
            )
        if plan.trials < stored.trials:
            raise RunError(
                f"{folder.path} is a run of {stored.trials} trials per object; --trials "
                f"{plan.trials} would drop some: give {stored.trials} or more"
            )
        history = folder.read_info().get("sessions")
        sessions = history if isinstance(history, list) else []
    else:
        folder.clear(overwrite)
    try:
        folder.renumber_files(plan)
        store = folder.open_store(plan, retry_errors)
    except OSError as error:
        raise folder.write_error(error) from error
    return Keeper(plan, folder, sessions, store)
