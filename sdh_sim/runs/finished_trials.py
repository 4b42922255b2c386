"""What a run has finished: which trials, how they ended, and how they get into the table.

Only trial numbers and counts are in memory; rows stay on disk.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa

from sdh_sim.errors import RecordError, RunError, one_line
from sdh_sim.records import FAILURES, TrialRow, to_rows, write_groups
from sdh_sim.runs.columns import columns_of_run
from sdh_sim.runs.plan import RunPlan, trial_seed
from sdh_sim.runs.shards import Index, Rows, ShardWriter, join, place

_WAY_OUT = "repair it from a copy, or start again with --overwrite or another --out"
_KEYS = ("trial", "object", "seed", "success", "failure")


@contextlib.contextmanager
def _open(table: Path, shards: Iterable[Path], plan: RunPlan) -> Iterator[Rows]:
    """The rows; whatever is damaged becomes a RunError."""
    try:
        rows = Rows(table, shards, columns_of_run(plan.settings))
        try:
            yield rows
        finally:
            rows.close()
    except RecordError as error:
        raise RunError(f"{error}; {_WAY_OUT}") from error


class TrialNumbers:
    """The number in the plan of a trial that has an object, a seed and perhaps an older number."""

    def __init__(self, plan: RunPlan) -> None:
        self._plan = plan
        self._first = dict(zip(plan.objects, plan.starts.tolist(), strict=False))
        self._by_seed: dict[str, tuple[np.ndarray, np.ndarray]] = {}

    def find(self, name: str, seed: int, trial: int) -> int | None:
        """The number, or None where the plan makes no such trial."""
        if name not in self._first:
            return None
        index = trial - self._first[name]
        within = 0 <= index < self._plan.trials_of(name)
        if within and trial_seed(self._plan.seed, name, index) == seed:
            return trial
        seeds, order = self._seeds(name)  # the run had fewer trials then, or this is another run's
        at = int(np.searchsorted(seeds, seed))
        if at == len(seeds) or seeds[at] != seed:
            return None
        return self._first[name] + int(order[at])

    def _seeds(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        if name not in self._by_seed:
            plan = self._plan
            count = plan.trials_of(name)
            each = (trial_seed(plan.seed, name, i) for i in range(count))
            seeds = np.fromiter(each, np.int64, count)
            order = np.argsort(seeds)
            self._by_seed[name] = seeds[order], order
        return self._by_seed[name]


def _locate(rows: Rows, plan: RunPlan, drop: str | None = None) -> tuple[Index, Counter, bool]:
    """Every trial once, how many of each object ended how, and whether all of it is as stored.

    Args:
        rows: what there is.
        plan: gives the numbers, which it may have moved.
        drop: failure whose trials are left out.

    Raises:
        RunError: a trial that the plan does not make, or one twice in the table.
    """
    numbers = TrialNumbers(plan)
    pieces: list[Index] = []
    failures: list[np.ndarray] = []
    as_stored = True
    for source, block, table in rows.parts(_KEYS):
        path = rows.sources[source].path
        new = _numbers_of(table, numbers, plan, path)
        as_stored &= bool(np.array_equal(new, table.column("trial").to_numpy()))
        pieces.append(place(new, source, block))
        kinds = {name: code for code, name in enumerate(FAILURES)}
        failures.append(np.array([kinds[f] for f in table.column("failure").to_pylist()], np.int8))
    index = join(pieces)
    codes = np.concatenate([*failures, np.zeros(0, np.int8)])
    in_table = index.trial[index.source == 0] if rows.sources else index.trial
    if len(np.unique(in_table)) != len(in_table):
        raise RunError(f"{rows.sources[0].path} holds a trial twice; {_WAY_OUT}")
    _, first = np.unique(index.trial, return_index=True)
    if drop is not None:
        kept = first[codes[first] != FAILURES.index(drop)]
        as_stored &= len(kept) == len(first)
        first = kept
    index, codes = index.take(first), codes[first]
    objects = np.searchsorted(plan.starts, index.trial, side="right") - 1
    tally = Counter[tuple[str, str]]()
    for which, code in zip(*np.unique(np.stack([objects, codes]), axis=1), strict=True):
        mine = (objects == which) & (codes == code)
        tally[plan.objects[which], FAILURES[code]] = int(mine.sum())
    return index, tally, as_stored


def _numbers_of(table: pa.Table, numbers: TrialNumbers, plan: RunPlan, path: Path) -> np.ndarray:
    for name in _KEYS:
        if table.column(name).null_count:
            raise RunError(f"{path} has a row without {name!r}; {_WAY_OUT}")
    found: list[int] = []
    for trial, name, seed, success, failure in zip(
        *(table.column(key).to_pylist() for key in _KEYS), strict=True
    ):
        number = numbers.find(name, seed, trial)
        if number is None:
            raise RunError(
                f"{path} holds trial {trial} ({one_line(name)}, seed {seed}), which the settings "
                "in run.json do not make; start again with --overwrite or another --out"
            )
        if failure not in FAILURES or success != (failure == "none"):
            raise RunError(
                f"{path}: trial {trial} has success {success} and failure "
                f"{one_line(repr(failure))}; {_WAY_OUT}"
            )
        found.append(number)
    return np.array(found, np.int64)


def read_finished(table: Path, shards: Iterable[Path], plan: RunPlan) -> Iterator[TrialRow]:
    """Every finished trial's row by number in the plan; a part of them is in memory at a time.

    Raises:
        RunError: the table or a shard is damaged, or holds trials that the plan does not make.
    """
    with _open(table, shards, plan) as rows:
        index, _, _ = _locate(rows, plan)
        for group in rows.groups(index):
            yield from to_rows(group)


def write_finished(table: Path, shards: Iterable[Path], plan: RunPlan, path: Path) -> None:
    """Write a table of every finished trial elsewhere; raises as ``read_finished``, and OSError."""
    with _open(table, shards, plan) as rows:
        index, _, _ = _locate(rows, plan)
        write_groups(rows.groups(index), path, columns_of_run(plan.settings))


class FinishedTrials:
    """The finished trials of a run that is going on.

    Attributes:
        done: (plan.total,) whether each trial is on disk.
        counts: trials on disk by object and failure.

    Raises:
        RunError: as ``read_finished``.
        OSError: the table had to be written (trial numbers moved, errors were dropped) and the
            disk refused.
    """

    def __init__(self, table: Path, shards: Path, plan: RunPlan, retry_errors: bool) -> None:
        self.table = table
        self.done = np.zeros(plan.total, bool)
        self._plan = plan
        self._added = columns_of_run(plan.settings)
        self._shards = ShardWriter(shards, self._added)
        for left in shards.glob("*.tmp"):
            left.unlink()
        files = self._shards.list()
        with _open(table, files, plan) as rows:
            drop = "error" if retry_errors else None
            index, self.counts, as_stored = _locate(rows, plan, drop)
            self.done[index.trial] = True
            if not as_stored:
                self._write(rows, index)
            else:
                sizes = np.bincount(index.source, minlength=len(rows.sources))
                behind = sizes[len(sizes) - len(files) :]
                self._shards.adopt(zip(files, behind.tolist(), strict=True))

    @property
    def kept(self) -> int:
        """Trials on disk."""
        return self.counts.total()

    @property
    def in_shards(self) -> int:
        """Those of them that the table lacks."""
        return self._shards.rows

    def append(self, rows: Iterable[TrialRow]) -> None:
        """Keep finished trials; they are on the disk when this returns.

        Raises:
            OSError: the disk refused; nothing of them is kept.
        """
        rows = list(rows)
        if not rows:
            return
        self._shards.append(rows)
        for row in rows:
            self.done[row["trial"]] = True
            self.counts[row["object"], row["failure"]] += 1

    def compact(self) -> None:
        """Bring all trials into the table; raises OSError and changes nothing where it cannot."""
        files = self._shards.list()
        if files or not self.table.exists():
            with _open(self.table, files, self._plan) as rows:
                self._write(rows, rows.index().once())

    def _write(self, rows: Rows, index: Index) -> None:
        write_groups(rows.groups(index), self.table, self._added)
        self._shards.clear()
