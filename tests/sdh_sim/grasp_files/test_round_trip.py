"""Files of grasps that are written can be read again, to the last bit, here and by others."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml

from sdh_sim.errors import GraspFileError
from sdh_sim.grasp_files import (
    GraspEntry,
    find_grasp_set,
    read_grasp_set,
    read_grasps,
    write_grasps,
)
from sdh_sim.grasp_files.grasp_entry import CLOSED, COLUMNS, NUMBERS, OPEN
from tests.support.grasp_entries import entries
from tests.support.sdh2 import MOTOR_NAMES

TABLES = (".parquet", ".csv", ".json")
ALL = (*TABLES, ".yaml")


def assert_same(first: list[GraspEntry], second: list[GraspEntry]) -> None:
    """Text alike, numbers within 1e-12, and no value more or less."""
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        a, b = one.values(), other.values()
        for name in COLUMNS:
            if name in NUMBERS and a[name] is not None:
                assert b[name] == pytest.approx(a[name], rel=0.0, abs=1e-12), name
            else:
                assert a[name] == b[name], name


@pytest.mark.parametrize("ending", TABLES)
def test_a_table_holds_every_value(tmp_path, ending):
    path = tmp_path / f"grasps{ending}"
    written = entries(24)
    write_grasps(written, path)
    assert_same(written, read_grasps(path, ["box", "oval_bottle"]))
    assert_same(written, read_grasps(path))


def test_isaac_grasp_holds_every_value(tmp_path):
    path = tmp_path / "grasps.yaml"
    written = entries(24, ("box",))
    write_grasps(written, path)
    assert_same(written, read_grasps(path, ["box"]))


@pytest.mark.parametrize("ending", ALL)
def test_what_is_read_and_written_again_has_the_same_bytes(tmp_path, ending):
    first, second = tmp_path / f"a{ending}", tmp_path / f"b{ending}"
    write_grasps(entries(24, ("box",)), first)
    write_grasps(read_grasps(first, ["box"]), second)
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("ending", ALL)
def test_the_reference_has_the_digest_of_the_bytes(tmp_path, ending):
    path = tmp_path / f"a{ending}"
    write_grasps(entries(3, ("box",)), path)
    reference, found = find_grasp_set(path, ["box"])
    assert reference.path == str(path)
    assert len(found) == 3
    path.write_bytes(path.read_bytes() + b"\n" if ending != ".parquet" else b"x")
    with pytest.raises(GraspFileError, match="has changed since the run began"):
        read_grasp_set(reference, ["box"])


def test_isaac_grasp_is_what_other_readers_expect(tmp_path):
    """PyYAML's own loader, which Isaac Sim uses, gives every number as a number."""
    path = tmp_path / "grasps.yaml"
    tiny = np.array([1e-05, -2e-07, 0.25, 0.0, 1.0, 0.0, 0.0])  # "1e-05" is text in YAML 1.1
    written = entries(12, ("box",))
    written.append(GraspEntry("box", "tiny", tiny, "parallel", object_yaw=1e-05, confidence=1e-09))
    write_grasps(written, path)
    document = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert document["format"] == "isaac_grasp"
    assert document["format_version"] == 1.0
    for entry in written:
        grasp = document["grasps"][entry.name]
        turn = grasp["orientation"]
        assert [*grasp["position"], turn["w"], *turn["xyz"]] == entry.palm_pose.tolist()
        closed = entry.closing.angles(1.0) if entry.preshape else entry.closed
        assert closed is not None
        assert grasp["cspace_position"] == dict(zip(MOTOR_NAMES, closed.tolist(), strict=True))
        assert set(grasp["pregrasp_cspace_position"]) == set(MOTOR_NAMES)
        assert grasp["confidence"] == entry.confidence
        if entry.object_yaw is not None:
            assert grasp["object_yaw"] == entry.object_yaw


@pytest.mark.parametrize("ending", TABLES)
def test_tables_of_pandas_and_polars_are_read(tmp_path, ending):
    written = entries(8, ("box",))
    rows = [entry.values() for entry in written]
    by_pandas, by_polars = tmp_path / f"pandas{ending}", tmp_path / f"polars{ending}"
    frame, other = pd.DataFrame(rows), pl.DataFrame(rows, infer_schema_length=None)
    match ending:
        case ".parquet":
            frame.to_parquet(by_pandas, index=False)
            other.write_parquet(by_polars)
        case ".csv":
            frame.to_csv(by_pandas, index=False)
            other.write_csv(by_polars)
        case _:
            by_pandas.write_text(json.dumps(rows), encoding="utf-8")
            other.write_json(by_polars)
    assert_same(written, read_grasps(by_pandas))
    assert_same(written, read_grasps(by_polars))


def test_single_precision_and_whole_numbers_are_numbers(tmp_path):
    row = {key: [0] for key in ("palm_x", "palm_y", "palm_z", "palm_qx", "palm_qy", "palm_qz")}
    table = pa.table({**row, "palm_qw": pa.array([1.0], pa.float32()), "preshape": ["parallel"]})
    pq.write_table(table, tmp_path / "a.parquet")
    (entry,) = read_grasps(tmp_path / "a.parquet", ["box"])
    assert entry.palm_pose.tolist() == [0, 0, 0, 1, 0, 0, 0]
    assert (entry.object, entry.name, entry.ratio) == ("box", "grasp_0", None)


def test_grasps_without_names_are_numbered_by_object(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "object,preshape,name,palm_x,palm_y,palm_z,palm_qw,palm_qx,palm_qy,palm_qz\n"
        "box,parallel,,0,0,0.2,0,1,0,0\n"
        "mug,parallel,handle,0,0,0.2,0,1,0,0\n"
        "box,parallel,,0,0,0.3,0,1,0,0\n"
        "mug,parallel,,0,0,0.3,0,1,0,0\n"
    )
    found = [(entry.object, entry.name) for entry in read_grasps(path)]
    assert found == [
        ("box", "grasp_0"), ("mug", "handle"), ("box", "grasp_1"), ("mug", "grasp_1"),
    ]  # fmt: skip


def test_a_quaternion_of_nearly_unit_length_is_kept_as_it_is(tmp_path):
    pose = np.array([0.0, 0.0, 0.2, *np.array([0.6, 0.8, 0.0, 0.0]) * (1 + 9e-7)])
    path = tmp_path / "a.json"
    write_grasps([GraspEntry("box", "a", pose, "parallel")], path)
    assert read_grasps(path)[0].palm_pose.tolist() == pose.tolist()


def test_a_coupled_joint_with_the_angle_of_its_motor_is_taken(tmp_path):
    path = tmp_path / "a.yaml"
    entry = next(e for e in entries(1, ("box",)) if e.open is not None)
    write_grasps([entry], path)
    text = path.read_text(encoding="utf-8")
    spread = next(line for line in text.splitlines() if line.startswith("      spread: "))
    path.write_text(text.replace(spread, f"{spread}\n{spread.replace('d:', 'd_coupled:')}", 1))
    assert_same([entry], read_grasps(path, ["box"]))


def test_the_columns_are_those_of_the_motors():
    assert len(OPEN) == len(CLOSED) == 7
    assert len(set(COLUMNS)) == len(COLUMNS)


def test_a_disk_that_refuses_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    write_grasps(entries(2), path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_grasps(entries(4), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]
