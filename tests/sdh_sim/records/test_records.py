"""The table: what goes in comes out, in any reader, and never half."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sdh_sim import records
from sdh_sim.errors import RecordError
from tests.support.repository import ROOT
from tests.support.trial_stand_ins import make_row


def rows(count: int) -> list[dict[str, Any]]:
    return [{**make_row("box", seed), "trial": seed} for seed in range(count)]


def test_round_trip_keeps_every_value(tmp_path):
    path = tmp_path / "trials.parquet"
    before = [records.normalise(row) for row in rows(25)]
    records.write_rows(before, path)
    after = records.read_rows(path)
    assert [records.differing_columns(a, b) for a, b in zip(before, after, strict=True)] == [
        []
    ] * 25
    assert any(row["tactile_proximal"] is None for row in after)
    assert any(row["q_linf"] is None for row in after)
    np.testing.assert_array_equal(
        after[3]["tactile_distal"], rows(4)[3]["tactile_distal"].astype(np.float32)
    )


def test_same_rows_same_bytes_in_any_order_and_after_a_round_trip(tmp_path):
    first, second, third = (tmp_path / name for name in "abc")
    records.write_rows(rows(12), first)
    records.write_rows(rows(12)[::-1], second)
    records.write_rows(records.read_rows(first), third)
    assert first.read_bytes() == second.read_bytes() == third.read_bytes()


def test_an_empty_table_round_trips(tmp_path):
    records.write_rows([], tmp_path / "t")
    assert records.read_rows(tmp_path / "t") == []
    assert records.stack(records.read_table(tmp_path / "t"), "tactile_distal").shape == (
        0,
        3,
        13,
        6,
    )


def test_nan_scalar_becomes_null(tmp_path):
    row = {**make_row("box", 1), "trial": 0, "q_linf": float("nan"), "q_l1": np.float32("nan")}
    records.write_rows([row], tmp_path / "t")
    table = pq.read_table(tmp_path / "t")
    assert table["q_linf"].null_count == table["q_l1"].null_count == 1


def test_pandas_reads_it_as_it_is(tmp_path):
    path = tmp_path / "trials.parquet"
    records.write_rows(rows(8), path)
    frame = pd.read_parquet(path)
    assert list(frame.columns) == [column.name for column in records.COLUMNS]
    have = frame[frame.failure != "no_contact"]
    assert len(have) > 1
    for seed, cell in zip(have.seed, have.tactile_proximal, strict=True):
        wanted = make_row("box", int(seed))["tactile_proximal"].astype(np.float32)
        np.testing.assert_array_equal(np.array(cell.tolist()).tolist(), wanted.tolist())


@pytest.mark.parametrize("library", ["polars", "duckdb"])
def test_other_readers_see_the_same_element(tmp_path, library):
    path = tmp_path / "trials.parquet"
    records.write_rows(rows(8), path)
    wanted = [np.float32(row["tactile_distal"][2, 12, 5]) for row in rows(8)]
    reader = pytest.importorskip(library, reason=f"{library} is not installed")
    if library == "polars":
        got = [cell[2][12][5] for cell in reader.read_parquet(path)["tactile_distal"].to_list()]
    else:
        sql = f"select tactile_distal[3][13][6] from '{path}' order by trial"
        got = [cell for (cell,) in reader.sql(sql).fetchall()]
    assert got == wanted


def test_stack_gives_arrays_with_nan_for_null(tmp_path):
    records.write_rows(rows(10), tmp_path / "t")
    table = records.read_table(tmp_path / "t")
    stacked = records.stack(table, "tactile_proximal")
    assert stacked.shape == (10, 3, 14, 6)
    for seed, array in enumerate(stacked):
        truth = make_row("box", seed)["tactile_proximal"]
        if truth is None:
            assert np.isnan(array).all()
        else:
            np.testing.assert_array_equal(array, truth.astype(np.float32))
    scalars = records.stack(table, "q_linf")
    for seed, value in enumerate(scalars):
        truth = make_row("box", seed)["q_linf"]
        assert np.isnan(value) if truth is None else value == truth


def test_stack_works_on_a_slice_and_on_chunks(tmp_path):
    table = records.to_table(rows(10))
    whole = records.stack(table, "joint_angles_rad")
    np.testing.assert_array_equal(records.stack(table.slice(4, 3), "joint_angles_rad"), whole[4:7])
    chunks = pa.concat_tables([table.slice(0, 4), table.slice(4)])
    np.testing.assert_array_equal(records.stack(chunks, "joint_angles_rad"), whole)


def test_schema_says_units_and_shapes():
    assert records.SCHEMA.field("torque_limit_nm").metadata[b"unit"] == b"N m"
    assert records.SCHEMA.field("tactile_distal").metadata[b"shape"] == b"3x13x6"
    assert records.SCHEMA.metadata[b"tactile_unit"] == b"kPa"
    assert all(column.meaning for column in records.COLUMNS)
    names = [column.name for column in records.COLUMNS]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"colour": 1}, "unknown column 'colour'"),
        ({"seed": None}, "lacks column 'seed'"),
        ({"failure": "bored"}, "failure is 'bored'"),
        ({"failure": "slipped", "success": True}, "success is True but failure is 'slipped'"),
        ({"joint_angles_rad": [1.0] * 6}, r"shape \(6,\); expected \(7,\)"),
        ({"tactile_distal": np.zeros((3, 14, 6))}, "tactile_distal"),
        ({"contacts": 1.5}, "'contacts' got 1.5"),
        ({"contacts": True}, "'contacts' got True"),
        ({"q_linf": "much"}, "'q_linf' got 'much'"),
        ({"success": 1}, "'success' got 1"),
        ({"seed": 2**63}, "'seed' got 9223372036854775808"),
    ],
)
def test_a_wrong_row_is_refused_by_name(change, words):
    row = {**make_row("box", 1), "trial": 0, **change}
    with pytest.raises(RecordError, match=words):
        records.to_table([row])


def test_reading_what_is_no_table(tmp_path):
    with pytest.raises(RecordError, match="does not exist"):
        records.read_table(tmp_path / "none")
    junk = tmp_path / "junk"
    junk.write_bytes(b"PAR1 nothing of the kind")
    with pytest.raises(RecordError, match="not a readable parquet file"):
        records.read_table(junk)
    with pytest.raises(RecordError, match="not a readable parquet file"):
        records.read_table(tmp_path)
    other = tmp_path / "other"
    pq.write_table(pa.table({"trial": [1]}), other)
    with pytest.raises(RecordError, match="no column 'object'"):
        records.read_table(other)
    pq.write_table(pa.table({"trial": ["x"]}), other)
    with pytest.raises(RecordError, match="'trial' is string; expected int64"):
        records.read_table(other, ["trial"])


def test_every_damaged_byte_is_an_error_of_ours_or_harmless(tmp_path):
    path = tmp_path / "t"
    records.write_rows(rows(3), path)
    good = path.read_bytes()
    rng = np.random.default_rng(0)
    said: list[str] = []
    for _ in range(150):
        bad = bytearray(good)
        bad[int(rng.integers(len(bad)))] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(bad))
        try:
            records.read_rows(path)
        except RecordError as error:
            said.append(str(error))
    assert said
    assert not any("\n" in text for text in said)
    for cut in rng.integers(len(good), size=30):
        path.write_bytes(good[: int(cut)])
        with pytest.raises(RecordError):
            records.read_rows(path)


def test_a_refused_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "t"
    records.write_rows(rows(3), path)
    before = path.read_bytes()
    (tmp_path / "t.tmp").mkdir()  # the temporary file cannot be opened
    with pytest.raises(OSError, match="directory"):
        records.write_rows(rows(5), path)
    assert path.read_bytes() == before


_WRITER = """
import sys
from pathlib import Path
sys.path.insert(0, ".")
from tests.support.trial_stand_ins import make_row
from sdh_sim import records
rows = [{**make_row("box", i), "trial": i} for i in range(int(sys.argv[2]))]
while True:
    rows.append({**make_row("box", len(rows)), "trial": len(rows)})
    records.write_rows(rows, Path(sys.argv[1]))
    print(len(rows), flush=True)
"""


def writer(path: Path, rows: int) -> subprocess.Popen[str]:
    """A process that writes ever longer tables, each announced by a line."""
    process = subprocess.Popen(
        [sys.executable, "-c", _WRITER, path, str(rows)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.readline()
    return process


def test_a_killed_writer_leaves_a_whole_table(tmp_path):
    rng = np.random.default_rng(5)
    for attempt in range(3):
        path = tmp_path / f"{attempt}.parquet"
        process = writer(path, 0)
        time.sleep(float(rng.uniform(0.0, 0.3)))
        process.kill()
        said = process.communicate()[0].split()
        found = records.read_rows(path)
        # Whoever was killed between the rename and the print has one row more than said.
        assert len(found) - int(said[-1] if said else 1) in (0, 1)
        assert [row["seed"] for row in found] == list(range(len(found)))


def test_a_reader_never_sees_part_of_a_table(tmp_path):
    path = tmp_path / "t"
    process = writer(path, 500)
    ends = set()
    stop = time.monotonic() + 1.5
    while time.monotonic() < stop:
        ends.add(path.read_bytes()[-4:])
    process.kill()
    process.communicate()
    assert ends == {b"PAR1"}


def test_a_table_of_an_earlier_version_lacks_columns_and_gives_none(tmp_path):
    path = tmp_path / "trials.parquet"
    records.write_rows(rows(5), path)
    lacking = ["grasp_name", "infeasible_reason", "plan_palm_pose_object", "tactile_distal"]
    pq.write_table(pq.read_table(path).drop_columns(lacking), path)
    found = records.read_rows(path)
    assert all(row[name] is None for row in found for name in lacking)
    for row, wanted in zip(found, rows(5), strict=True):
        assert records.differing_columns(row, {**wanted, "tactile_distal": None}) == []
    assert np.isnan(records.stack(records.read_table(path), "tactile_distal")).all()
    with pytest.raises(RecordError, match="no column 'grasp_name'"):
        records.read_table(path, ["grasp_name"])
    pq.write_table(pq.read_table(path).drop_columns(["success"]), path)
    with pytest.raises(RecordError, match="no column 'success'"):
        records.read_rows(path)
