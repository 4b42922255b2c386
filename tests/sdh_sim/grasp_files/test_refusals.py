"""What is no file of grasps gets one line that says where, what and what would do."""

from __future__ import annotations

import json
import os

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sdh_sim.errors import GraspFileError
from sdh_sim.grasp_files import MAX_BYTES, read_grasps, write_grasps
from tests.support.grasp_entries import entries
from tests.support.sdh2 import MOTOR_NAMES

POSE = {"palm_x": 0.0, "palm_y": 0.0, "palm_z": 0.2}
POSE |= {"palm_qw": 0.0, "palm_qx": 1.0, "palm_qy": 0.0, "palm_qz": 0.0}
GOOD = {**POSE, "preshape": "parallel"}
ANGLES = {f"{end}_{name}": 0.1 * k for k, end in enumerate(("open", "closed")) for name in MOTOR_NAMES}  # fmt: skip  # noqa: E501


def refusal(path, objects=("box",)) -> str:
    with pytest.raises(GraspFileError) as caught:
        read_grasps(path, objects)
    text = str(caught.value)
    assert text.startswith(f"grasps: {path}") or str(path) in text or path.name in text
    assert text.isprintable()
    return text


def refused_row(tmp_path, row: dict, objects=("box",)) -> str:
    path = tmp_path / "grasps.json"
    path.write_text(json.dumps([GOOD, row]))
    return refusal(path, objects)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"palm_x": None}, "row 2 has no palm_x; the palm's pose needs palm_x, palm_y"),
        ({"palm_x": float("nan")}, "row 2 has palm_x nan; expected a finite number"),
        ({"palm_x": float("inf")}, "row 2 has palm_x inf; expected a finite number"),
        ({"palm_x": "left"}, "row 2 has palm_x 'left'; expected a number"),
        ({"palm_x": True}, "row 2 has palm_x True; expected a number"),
        ({"palm_x": [0.1]}, "row 2 has palm_x [0.1]; expected a number"),
        ({"palm_x": 10**400}, "expected a number"),
        ({"palm_z": 120.0}, "row 2 has palm_z 120; allowed is -10 to 10 m"),
        ({"palm_qx": 0.9}, "palm_qw … palm_qz of length 0.9; expected 1: divide it by its length"),
        ({"palm_qx": 1.0 + 2e-6}, "of length 1.000002; expected 1"),
        ({"preshape": None}, "row 2 has neither a preshape nor angles; give preshape, or open_spr"),
        ({"preshape": "fist"}, "row 2 has preshape 'fist'; choose one of parallel, cylindrical"),
        ({"preshape": 3}, "row 2 has preshape 3; expected text"),
        ({"ratio": 1.5}, "row 2 has ratio 1.5; allowed is 0 to 1"),
        ({"open_spread": 0.0}, "row 2 has a preshape and open_spread; give a preshape or angles"),
        ({"object_yaw": 90}, "row 2 has object_yaw 90; allowed is -6.283 to 6.283 rad"),
        ({"confidence": "high"}, "row 2 has confidence 'high'; expected a number"),
        ({"name": "a\nb"}, r"row 2 has name 'a\nb'; expected text that can be printed"),
        ({"name": "n" * 101}, "expected text that can be printed, at most 100 letters"),
        ({"name": "grasp_0"}, "row 2 is the second 'grasp_0' of box; give each grasp"),
        ({"object": "mug"}, "row 2 is for 'mug'; the objects are box: remove the row, or give"),
        ({"palm_qq": 0.0}, "has the column 'palm_qq'; is it palm_q"),
        ({"weight": 0.0}, "has the column 'weight'; known are object, name, palm_x"),
        ({"open_finger_joint": 0.0}, "the motors of this hand are spread, finger2_proximal"),
    ],
)
def test_a_value_that_cannot_be_used(tmp_path, change, says):
    assert says in refused_row(tmp_path, {**GOOD, **change})


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"closed_thumb_distal": None}, "row 2 has no closed_thumb_distal; give all seven angles"),
        ({"closed_spread": 1.6}, "row 2 cannot close: closed: got 1.6 for spread; its range"),
        ({"open_thumb_distal": -90}, "row 2 cannot close: open: got -90 for thumb_distal"),
        ({"ratio": 0.5}, "row 2 has a ratio without a preshape"),
        ({f"closed_{name}": 0.0 for name in MOTOR_NAMES}, "cannot close: closed: no finger joint"),
    ],
)
def test_angles_that_cannot_be_used(tmp_path, change, says):
    assert says in refused_row(tmp_path, {**POSE, **ANGLES, **change})


def test_a_row_without_an_object_takes_one_alone(tmp_path):
    assert "row 1 names no object, and there are 2: box, mug; add a column object" in refused_row(
        tmp_path, GOOD, ("box", "mug")
    )
    assert "row 1 names no object, and none is given" in refused_row(tmp_path, GOOD, ())


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.csv", b"", "holds no grasp; give at least one"),
        ("a.csv", b"name,object\n", "holds no grasp"),
        ("a.csv", b"name,object\n1,2,3\n", "has 3 cells in line 2; expected 2, as in its header"),
        ("a.csv", b"name,name\n1,2\n", "has the column name twice"),
        ("a.csv", b"name\n\xff\n", "is not CSV in UTF-8"),
        ("a.csv", b'name\n"a\n', "is not CSV in UTF-8: unexpected end of data"),
        ("a.csv", b"x;y;z\n1;2;3\n", "has the column 'x;y;z'"),
        ("a.json", b"", "is not JSON"),
        ("a.json", b"{}", "holds {}; expected a list with an object for each grasp"),
        ("a.json", b"[1]", "row 1 is 1; expected an object"),
        ("a.json", b'[{"palm_x": 1, "palm_x": 2}]', "has 'palm_x' twice"),
        ("a.json", b"[" * 50_000, "is not JSON"),
        ("a.json", b"[" * 200_000, "is not a list of grasps"),
        ("a.parquet", b"PAR1", "is not a readable Parquet file"),
        ("a.yaml", b"", "is not isaac_grasp YAML; expected format: isaac_grasp at its top"),
        ("a.yaml", b"format: other", "is not isaac_grasp YAML"),
        ("a.yaml", b"format: isaac_grasp\nformat_version: 2.0", "has format_version '2.0'"),
        ("a.yaml", b"format: isaac_grasp\nformat_version: 1.0", "has no mapping grasps"),
        ("a.yaml", b"a: [1", "is not YAML in line"),
        ("a.yaml", b"a: 1\n---\nb: 2", "holds several YAML documents"),
        ("a.yaml", b"a: 1\na: 2", "has the key 'a' twice in line 2"),
        ("a.yaml", b"? [a]\n: 2", "has a key that is no text in line 1"),
        ("a.yaml", b"a: !!float 1", "has a tag in line 1; leave it out"),
        ("a.yaml", b"a: !!python/object/apply:os.abort []", "has a tag in line 1"),
        ("a.yaml", b"a: " + b"[" * 9, "is nested more than 8 deep in line 1"),
        ("a.yaml", b"a: " + b"[" * 5000, "in line 1"),
        ("a.txt", b"", "expected a name that ends in .parquet, .csv, .json, .yaml, .yml"),
    ],
)  # fmt: skip
def test_a_file_that_is_none_of_the_formats(tmp_path, name, content, says):
    path = tmp_path / name
    path.write_bytes(content)
    assert says in refusal(path)


def test_a_small_yaml_file_cannot_become_a_large_value(tmp_path):
    path = tmp_path / "a.yaml"
    levels = [f"l{k}: &l{k} [{', '.join([f'*l{k - 1}'] * 9)}]" for k in range(1, 9)]
    path.write_text("l0: &l0 [x, x]\n" + "\n".join(levels))
    assert "has the anchor or alias 'l0' in line 1; write the value itself" in refusal(path)
    path.write_text("a: [x]\nb: {<<: *a}")
    assert "has the anchor or alias 'a' in line 2" in refusal(path)


def test_a_million_rows_are_refused_with_the_limit(tmp_path):
    says = "has more than 100000 grasps; split the file"
    (tmp_path / "a.csv").write_text(",".join(GOOD) + "\n" + "0,0,0.2,0,1,0,0,parallel\n" * 10**6)
    assert says in refusal(tmp_path / "a.csv")
    (tmp_path / "a.json").write_text("[" + ",".join(["{}"] * 10**6) + "]")
    assert says in refusal(tmp_path / "a.json")
    pq.write_table(pa.table({"palm_x": [0.0] * 10**6}), tmp_path / "a.parquet")
    assert says in refusal(tmp_path / "a.parquet")
    head = "format: isaac_grasp\nformat_version: 1.0\ngrasps:\n"
    (tmp_path / "a.yaml").write_text(head + "".join(f" {k}: 0\n" for k in range(10**6)))
    assert "has 1000000 grasps; allowed are 100000: split the file" in refusal(tmp_path / "a.yaml")


def test_a_file_that_is_too_large_or_no_file(tmp_path):
    with open(tmp_path / "a.csv", "wb") as file:
        file.truncate(MAX_BYTES + 1)
    assert f"has more than {MAX_BYTES} bytes" in refusal(tmp_path / "a.csv")
    (tmp_path / "b.csv").mkdir()
    assert "cannot read" in refusal(tmp_path / "b.csv")
    assert "No such file" in refusal(tmp_path / "c.csv")
    os.mkfifo(tmp_path / "d.csv")
    assert "is not a file" in refusal(tmp_path / "d.csv")


def test_text_that_every_row_repeats_is_not_unpacked(tmp_path):
    path = tmp_path / "a.parquet"
    long = pa.DictionaryArray.from_arrays(pa.array([0] * 100_000), pa.array(["x" * 10_000_000]))
    pq.write_table(pa.table({"name": long}), path, compression="zstd")
    assert "has text of 10000000 bytes in name; allowed are 100 letters" in refusal(path)


def test_parquet_with_other_types(tmp_path):
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"palm_x": ["0"]}), path)
    assert "has string in column palm_x; expected numbers" in refusal(path)
    pq.write_table(pa.table({"name": [1]}), path)
    assert "has int64 in column name; expected text" in refusal(path)
    pq.write_table(pa.table({"palm_x": [[0.0]]}), path)
    assert "in column palm_x; expected numbers" in refusal(path)


def yaml_text(tmp_path) -> str:
    path = tmp_path / "good.yaml"
    write_grasps(entries(2, ("box",)), path)
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("orientation:", "turn:", "has no orientation {w: …, xyz: […]}"),
        ("position: [", "position: [0.1, ", "expected a list of three numbers"),
        ("      spread: ", "      left_knuckle: ", "has the joint 'left_knuckle' in cspace_pos"),
        ("    cspace_position:", "    joints:", "has no cspace_position; expected angles by joint"),
        ("      thumb_distal: ", "      spread_coupled: ", "has no thumb_distal in cspace_positi"),
        ("w: ", "w: 1", "has palm_qw 1"),
        ("    preshape: cylindrical", "    preshape: parallel", "but other angles in pregrasp_csp"),
        ("preshape: cylindrical", "preshape: fist", "has preshape 'fist'; choose one of"),
        ("ratio: 0.", "ratio: 7.", "allowed is 0 to 1"),
        ("confidence: ", "confidence: x", "expected a number"),
    ],
)
def test_isaac_grasp_that_cannot_be_used(tmp_path, old, new, says):
    text = yaml_text(tmp_path)
    assert old in text
    path = tmp_path / "bad.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert says in refusal(path)
    assert "grasp '" in refusal(path)


def test_a_coupled_joint_of_its_own_angle(tmp_path):
    path = tmp_path / "bad.yaml"
    text = yaml_text(tmp_path).replace(
        "      spread: ", "      spread_coupled: 0.7\n      spread: "
    )
    path.write_text(text, encoding="utf-8")
    assert "spread_coupled '0.7' in pregrasp_cspace_position; it always has the angle" in refusal(
        path
    )


def test_yaml_holds_one_object(tmp_path):
    with pytest.raises(GraspFileError, match="would hold grasps of box, oval_bottle"):
        write_grasps(entries(2), tmp_path / "a.yaml")
    with pytest.raises(GraspFileError, match=r"expected a name that ends in \.parquet"):
        write_grasps(entries(2), tmp_path / "a.xlsx")
    assert not list(tmp_path.iterdir())
