"""Finished trials on disk: the same table from any shards, in memory that does not grow."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from sdh_sim.errors import RunError
from sdh_sim.records import ROW_GROUP, TrialRow, normalise, read_rows, write_rows
from sdh_sim.runs import RunFolder
from sdh_sim.runs.shards import read_shard, shard_files
from tests.support.repository import ROOT
from tests.support.trial_stand_ins import make_row, plan

TRIALS = 700  # of two objects: more than a row group


@pytest.fixture(scope="module")
def rows() -> list[TrialRow]:
    """All rows of a run of two row groups; most are copies of a few with their own numbers."""
    kinds = [make_row("box", seed) for seed in range(20)]
    jobs = plan(TRIALS).jobs()
    return [
        normalise(
            {
                **kinds[job.trial % 20],
                **{"trial": job.trial, "object": job.settings.object, "seed": job.seed},
            }
        )
        for job in jobs
    ]


@pytest.fixture(scope="module")
def wanted(rows, tmp_path_factory) -> bytes:
    """The bytes of their table."""
    path = tmp_path_factory.mktemp("wanted") / "trials.parquet"
    write_rows(rows, path)
    assert pq.ParquetFile(path).num_row_groups == 2
    return path.read_bytes()


def fill(folder: RunFolder, rows: list[TrialRow], sizes: list[int], run=None) -> None:
    """Append rows in batches of these sizes, in turn."""
    finished = folder.open_finished(run or plan(TRIALS))
    at = turn = 0
    while at < len(rows):
        size = sizes[turn % len(sizes)]
        finished.append(rows[at : at + size])
        at, turn = at + size, turn + 1


@pytest.mark.parametrize("sizes", [[1400], [500, 1], [37, 3]])
def test_any_shards_in_any_order_give_the_same_bytes(tmp_path, rows, wanted, sizes):
    folder = RunFolder(tmp_path)
    order = np.random.default_rng(0).permutation(len(rows))
    fill(folder, [rows[i] for i in order], sizes)
    finished = folder.open_finished(plan(TRIALS))
    assert finished.kept == finished.in_shards == len(rows)
    assert sum(finished.counts.values()) == len(rows)
    finished.compact()
    assert folder.table.read_bytes() == wanted
    assert not folder.shards.exists()
    assert finished.in_shards == 0


def test_a_table_and_shards_join_to_the_same_bytes(tmp_path, rows, wanted):
    folder = RunFolder(tmp_path)
    write_rows(rows[::3], folder.table)
    fill(folder, rows[1::3], [64])
    fill(folder, rows[2::3], [100])
    folder.open_finished(plan(TRIALS)).compact()
    assert folder.table.read_bytes() == wanted


def test_small_shards_are_joined(tmp_path, rows):
    folder = RunFolder(tmp_path)
    fill(folder, rows[: ROW_GROUP + 64], [16])
    sizes = [read_shard(path).num_rows for path in shard_files(folder.shards)]
    assert sizes == [ROW_GROUP] + [16] * 4


def test_a_kill_between_a_rename_and_a_deletion_doubles_nothing(tmp_path, rows, wanted):
    folder = RunFolder(tmp_path)
    fill(folder, rows, [400])
    left = {path: path.read_bytes() for path in shard_files(folder.shards)}
    folder.open_finished(plan(TRIALS)).compact()
    folder.shards.mkdir()
    for path, data in left.items():
        path.write_bytes(data)
    (folder.shards / "00000009-00000000.arrow.tmp").write_bytes(b"half")
    assert [row["trial"] for row in folder.finished(plan(TRIALS))] == list(range(len(rows)))
    finished = folder.open_finished(plan(TRIALS))
    assert finished.kept == len(rows)
    finished.compact()
    assert folder.table.read_bytes() == wanted
    assert not folder.shards.exists()


def test_rows_get_the_numbers_of_a_bigger_run(tmp_path, rows):
    folder = RunFolder(tmp_path)
    fill(folder, rows, [300])
    bigger = plan(TRIALS + 1)
    found = [row["trial"] for row in folder.finished(bigger)]
    assert found == [*range(TRIALS), *range(TRIALS + 1, 2 * TRIALS + 1)]
    finished = folder.open_finished(bigger)
    assert np.flatnonzero(~finished.done).tolist() == [TRIALS, 2 * TRIALS + 1]
    again = folder.open_finished(bigger)
    assert again.kept == len(rows)
    assert [row["trial"] for row in read_rows(folder.table)] == found


def test_damaged_shards_are_named(tmp_path, rows):
    folder = RunFolder(tmp_path)
    fill(folder, rows[:6], [3])
    first, second = shard_files(folder.shards)
    good = first.read_bytes()
    for bad in (b"", good[:-1], good[:-9] + b"x" + good[-8:]):
        first.write_bytes(bad)
        with pytest.raises(RunError, match=rf"{first} is damaged.*--overwrite"):
            folder.open_finished(plan(TRIALS))
        with pytest.raises(RunError, match="damaged"):
            list(folder.finished(plan(TRIALS)))
    first.write_bytes(good)
    assert folder.open_finished(plan(TRIALS)).kept == 6
    assert second.exists()


_GROW = """
import resource, sys, tempfile
from sdh_sim.records.rows import normalise
from sdh_sim.runs.folder import RunFolder
from tests.support.trial_stand_ins import make_row, plan
count = int(sys.argv[1])
row = normalise({**make_row("box", 1), "trial": 0})
run = plan(count, ("box",))
with tempfile.TemporaryDirectory() as path:
    folder = RunFolder(path)
    finished = folder.open_finished(run)
    jobs = run.jobs()
    for _ in range(count // 128):
        batch = [next(jobs) for _ in range(128)]
        finished.append({**row, "trial": job.trial, "seed": job.seed} for job in batch)
    finished.compact()
    finished = folder.open_finished(run)
    assert finished.kept == sum(1 for row in folder.finished(run)) == count, finished.kept
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def test_memory_does_not_grow_with_the_run():
    def peak(count: int) -> float:
        done = subprocess.run(
            [sys.executable, "-c", _GROW, str(count)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        )
        return float(done.stdout)

    # 8192 rows are 24 MB, as dicts of arrays 60 MB; some blocks of 3 MB are cached.
    assert peak(8192) - peak(2048) < 12.0
