"""A run of many trials: every finished one kept at once, an orderly stop, a way to go on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from sdh_sim.campaign.jobs import Executor, TrialFunction, TrialTask, run_jobs
from sdh_sim.campaign.session import RunResult, RunSession
from sdh_sim.campaign.stop_signals import StopSignals
from sdh_sim.errors import RunError
from sdh_sim.records import TrialRow
from sdh_sim.run_options import RunOptions
from sdh_sim.runs import (
    FinishedTrials,
    RunFolder,
    RunPlan,
    read_given_grasps,
    run_lock,
    versions,
    with_grasp,
)

OnStart = Callable[[RunResult], None]
OnTrial = Callable[[TrialRow], None]


def run_campaign(
    plan: RunPlan,
    out: str | Path,
    workers: int = 1,
    *,
    on_start: OnStart | None = None,
    on_trial: OnTrial | None = None,
    trial: TrialFunction | None = None,
    **options: Any,
) -> RunResult:
    """Run the trials that the folder lacks and keep each as soon as it has finished.

    The table's bytes depend on the plan alone: not on where trials run or how many at a time, nor
    on interruptions. A trial that raises, that does not end in time or whose process dies, is run
    once more and then is a row with the failure ``error``, its traceback in ``errors/``; the run
    goes on.

    Worker processes import the calling script anew: it must start the run below ``if __name__ ==
    "__main__":``, as Python's multiprocessing asks.

    Args:
        plan: what to run; with ``resume`` it may ask for more trials than the run had.
        out: folder of the run.
        workers: number of processes; a cluster (``scheduler``) has its own.
        on_start: called once with what earlier sessions finished.
        on_trial: called with each row of this session when it is on the disk.
        trial: what runs one trial: ``sdh_sim.trial.run_trial``, or a module-level stand-in.
        **options: the other fields of ``RunOptions`` by name: ``resume``, ``overwrite``,
            ``retry_errors``, ``rerun``, ``executor``, ``scheduler``, ``trial_timeout`` [s],
            ``save_every`` [s], ``command``. The page Settings of the documentation says what they
            mean.

    Raises:
        RunError, SettingsError: the folder or an option cannot be used; nothing was changed.
        Interrupted: Ctrl-C or SIGTERM; finished trials are kept.
        CampaignError: the disk refused, no worker starts or every trial fails; finished trials
            are kept.
    """
    how = RunOptions(workers=workers, **options)
    if how.executor == "dask":
        from sdh_sim.campaign import dask_cluster

        dask_cluster.check_available(how.scheduler)
    given = read_given_grasps(plan)
    folder = RunFolder(out)
    folder.make()
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(run_lock(folder.lock))
        except OSError as error:
            raise folder.write_error(error) from error
        session = _open_session(plan, folder, how)
        if on_start is not None:
            on_start(session.result)
        missing = plan.total - session.finished.kept
        slots = min(how.workers, max(missing, 1))
        session.begin(how, slots)
        stop = stack.enter_context(StopSignals())
        broken_by: BaseException | None = None
        try:
            if missing:
                executor = _executor(how, slots, _task(trial, how, folder))
                jobs = (with_grasp(plan.job(n), given) for n in _missing(session.finished))
                with contextlib.closing(run_jobs(jobs, executor)) as batches:
                    for batch in batches:
                        with stop.held():
                            rows = session.add(batch)
                        if on_trial is not None:
                            for row in rows:
                                on_trial(row)
                        session.save_if_due(how.save_every)
                session.check_all_failed()
        except BaseException as error:
            broken_by = error
        stop.ignore_further()
        session.close(broken_by)
    return session.result


def _missing(finished: FinishedTrials) -> Iterator[int]:
    # Looked up as they are needed: a list of a million numbers would be the largest part here.
    return (number for number in range(len(finished.done)) if not finished.done[number])


def _task(trial: TrialFunction | None, options: RunOptions, folder: RunFolder) -> TrialTask:
    # Workers of a cluster that was there before have an installation of their own.
    must_have = None if options.scheduler is None else versions()
    return TrialTask(trial, options.rerun, folder, must_have)


def _executor(options: RunOptions, slots: int, task: TrialTask) -> Executor:
    if options.executor == "dask":
        from sdh_sim.campaign.dask_cluster import DaskExecutor

        return DaskExecutor(slots, task, options.scheduler, options.trial_timeout)
    from sdh_sim.campaign.local_processes import ProcessExecutor

    return ProcessExecutor(slots, task, options.trial_timeout)


def _open_session(plan: RunPlan, folder: RunFolder, options: RunOptions) -> RunSession:
    history: list[dict[str, Any]] = []
    if options.resume and folder.holds_run():
        _check_continues(plan, folder)
        kept = folder.read_info().get("sessions")
        history = kept if isinstance(kept, list) else []
    else:
        folder.clear(options.overwrite)
    try:
        folder.renumber_files(plan)
        finished = folder.open_finished(plan, options.retry_errors)
    except OSError as error:
        raise folder.write_error(error) from error
    return RunSession(plan, folder, history, finished)


def _check_continues(plan: RunPlan, folder: RunFolder) -> None:
    stored = folder.read_plan()
    if changes := plan.changes_from(stored):
        raise RunError(
            f"{folder.path} was run with other settings: {'; '.join(changes)}; resume with the "
            "run's own (leave the option out), or choose another --out"
        )
    if plan.trials < stored.trials:
        raise RunError(
            f"{folder.path} is a run of {stored.trials} trials per "
            f"{'grasp' if stored.grasp_counts else 'object'}; --trials "
            f"{plan.trials} would drop some: give {stored.trials} or more"
        )
