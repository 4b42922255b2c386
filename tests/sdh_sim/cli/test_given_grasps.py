"""Grasps of a file through the command line: lifted, written, lifted again, refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sdh_sim.cli.app import main
from sdh_sim.grasp_files import GraspEntry, read_grasps, write_grasps
from sdh_sim.metrics import METRICS
from sdh_sim.records import differing_columns, read_rows, read_table
from sdh_sim.robot import closing_between, preshape_closing
from sdh_sim.runs import RunFolder
from tests.support import trial_stand_ins as stand_ins
from tests.support.command_line import fails, use_trial
from tests.support.grasp_entries import entries

# What a random grasp has and one of a file has not, and the other way round.
OTHERS = {"approach", "resampled_unreachable", "resampled_colliding"}
OTHERS |= {f"plan_{name}" for name in ("azimuth_rad", "roll_rad", "tilt_rad", "height_m")}
OTHERS |= {"plan_depth_m", "plan_offset_m", "grasp_name", "grasp_copy", "grasp_confidence"}
FAST = ["--workers", "1", "--timestep", "0.004"]


def lift(*arguments) -> int:
    return main(["lift", *map(str, arguments)])


@pytest.fixture(scope="module")
def random_run(tmp_path_factory):
    """Real random grasps of two objects, some of which hold and some do not."""
    out = tmp_path_factory.mktemp("random") / "run"
    objects = ["--object", "oval_bottle", "--object", "box"]
    assert lift(*objects, "--trials", 3, "--seed", 5, "--out", out, *FAST) == 0
    held = [row["success"] for row in read_rows(out / "trials.parquet")]
    assert {True, False} <= set(held), "take another seed"
    return out


def assert_same_grasps(first, second) -> None:
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        a, b = one.values(), other.values()
        sign = np.sign(one.palm_pose[3:] @ other.palm_pose[3:])  # q and -q are one rotation
        for name in set(a) - {"name"}:
            factor = sign if name.startswith("palm_q") else 1.0
            wanted = (
                a[name] if not isinstance(a[name], float) else pytest.approx(a[name], abs=1e-12)
            )
            assert (b[name] if isinstance(b[name], str | None) else factor * b[name]) == wanted, (
                name
            )


@pytest.mark.parametrize("ending", ["parquet", "json"])
def test_the_other_kinds_of_file_hold_the_same_grasps(random_run, tmp_path, capsys, ending):
    """To the last bit: lifted again, they end as those of a CSV file."""
    files = [tmp_path / f"a.{kind}" for kind in ("csv", ending)]
    for file in files:
        assert main(["grasps", str(random_run), "--out", str(file)]) == 0
        assert f"{file}: 6 grasps (oval_bottle 3, box 3)" in capsys.readouterr().out
    first, second = (
        [(entry.name, entry.object, entry.values()) for entry in read_grasps(file)]
        for file in files
    )
    assert first == second
    write_grasps(read_grasps(files[1]), tmp_path / f"b.{ending}")
    assert_same_grasps(read_grasps(files[1]), read_grasps(tmp_path / f"b.{ending}"))


def test_a_written_set_lifted_again_ends_the_same(random_run, tmp_path, capsys):
    file, again, out = tmp_path / "a.csv", tmp_path / "b.csv", tmp_path / "again"
    assert main(["grasps", str(random_run), "--out", str(file)]) == 0
    assert f"{file}: 6 grasps (oval_bottle 3, box 3)" in capsys.readouterr().out
    assert lift("--grasps", file, "--seed", 5, "--out", out, *FAST) == 0
    rows, repeated = read_rows(random_run / "trials.parquet"), read_rows(out / "trials.parquet")
    for row, other in zip(rows, repeated, strict=True):
        assert (other["object"], other["seed"]) == (row["object"], row["seed"])
        # A process that compiles the metrics may give other last bits than one that finds them
        # compiled. All else is the same to the last bit.
        assert set(differing_columns(row, other)) - set(METRICS) == OTHERS
        for name in METRICS:
            assert (other[name] is None) == (row[name] is None), name
            if row[name] is not None:
                assert other[name] == pytest.approx(row[name], rel=1e-9, abs=1e-12), name
        assert other["grasp_name"] == f"trial_{row['trial']}"
        assert other["grasp_copy"] == 0
        assert other["grasp_confidence"] == float(row["success"])
        assert other["approach"] is other["plan_azimuth_rad"] is None
        assert (other["preshape"], other["plan_opening"]) == (row["preshape"], row["plan_opening"])
    assert main(["grasps", str(out), "--out", str(again)]) == 0
    assert_same_grasps(read_grasps(file), read_grasps(again))


def test_a_written_isaac_grasp_file_lifted_again_ends_the_same(random_run, tmp_path, capsys):
    file, out = tmp_path / "box.yaml", tmp_path / "again"
    assert "would hold grasps of oval_bottle, box" in fails(
        capsys, "grasps", random_run, "--out", file
    )
    assert main(["grasps", str(random_run), "--object", "box", "--out", str(file)]) == 0
    arguments = ["--object", "box", "--grasps", file, "--seed", 5, "--out", out, *FAST]
    assert lift(*arguments) == 0
    rows = [r for r in read_rows(random_run / "trials.parquet") if r["object"] == "box"]
    for row, other in zip(rows, read_rows(out / "trials.parquet"), strict=True):
        assert (other["seed"], other["failure"]) == (row["seed"], row["failure"])
    assert main(["grasps", str(out), "--out", str(tmp_path / "b.yaml")]) == 0
    assert_same_grasps(read_grasps(file, ["box"]), read_grasps(tmp_path / "b.yaml", ["box"]))
    assert main(["grasps", str(out), "--success", "--out", str(tmp_path / "c.csv")]) == 0
    held = [entry.confidence for entry in read_grasps(tmp_path / "c.csv")]
    assert held == [1.0] * sum(bool(row["success"]) for row in rows)


def test_angles_of_one_s_own_are_lifted_and_written_as_angles(random_run, tmp_path):
    """A cylindrical closing by its name and by its angles."""
    assert main(["grasps", str(random_run), "--out", str(tmp_path / "a.json")]) == 0
    (one, *_) = (e for e in read_grasps(tmp_path / "a.json") if e.object == "oval_bottle")
    closing = preshape_closing("cylindrical")
    assert one.ratio is not None
    ends = closing.angles(one.ratio), closing.angles(1.0)
    by_name = GraspEntry(one.object, "name", one.palm_pose, "cylindrical", one.ratio)
    by_angles = GraspEntry(one.object, "angles", one.palm_pose, open=ends[0], closed=ends[1])
    file, out = tmp_path / "b.csv", tmp_path / "out"
    write_grasps([by_name, by_angles], file)
    assert lift("--grasps", file, "--out", out, *FAST) == 0
    first, second = read_rows(out / "trials.parquet")
    assert "infeasible" not in (first["failure"], second["failure"]), "take another grasp"
    assert (first["preshape"], second["preshape"]) == ("cylindrical", None)
    assert second["plan_opening"] == 0.0
    assert second["plan_open_rad"] == pytest.approx(ends[0], abs=1e-12)
    assert second["plan_closed_rad"] == pytest.approx(ends[1], abs=1e-12)
    assert closing_between(*ends).angles(0.5) == pytest.approx((ends[0] + ends[1]) / 2)
    assert main(["grasps", str(out), "--out", str(tmp_path / "c.csv")]) == 0
    for entry, written in zip(read_grasps(tmp_path / "c.csv"), (by_name, by_angles), strict=True):
        assert entry.preshape == written.preshape
        assert entry.object_yaw is not None  # the one that the arm could do
        assert (entry.open is None) == (written.open is None)


def test_grasps_that_cannot_be_tried_are_counted_apart(random_run, tmp_path, capsys):
    assert main(["grasps", str(random_run), "--out", str(tmp_path / "a.csv")]) == 0
    good = [e for e in read_grasps(tmp_path / "a.csv") if e.object == "box"][:1]
    turn = [1.0, 0.0, 0.0, 0.0]
    far = GraspEntry("box", "far", np.array([3.0, 0.0, 0.0, *turn]), "parallel")
    inside = GraspEntry("box", "inside", np.array([0.0, 0.0, 0.0, *turn]), "parallel")
    file, out = tmp_path / "b.csv", tmp_path / "out"
    write_grasps([*good, far, inside], file)
    capsys.readouterr()
    assert lift("--grasps", file, "--out", out, "--rerun", "all", *FAST) == 0
    printed = capsys.readouterr().out
    assert next(line for line in printed.splitlines() if line.strip()).split()[2] == "infeasible"
    (line,) = (line for line in printed.splitlines() if line.strip().startswith("box"))
    rows = read_rows(out / "trials.parquet")
    held = sum(bool(row["success"]) for row in rows)
    assert line.split()[1:5] == ["3", "2", str(held), f"({100 * held}"]
    assert [row["failure"] == "infeasible" for row in rows] == [False, True, True]
    assert rows[1]["infeasible_reason"]
    assert rows[2]["infeasible_reason"] != rows[1]["infeasible_reason"]
    assert rows[1]["success"] is False
    assert rows[1]["q_linf"] is None
    assert [p.name for p in RunFolder(out).recordings.iterdir()] == ["box-000000.rrd"]

    assert main(["compare", str(out), "--csv", str(tmp_path / "c.csv"), "--all"]) == 0
    compared = capsys.readouterr().out
    assert "2 trials left out: the arm cannot do their grasp without a collision" in compared
    assert "simulation was unstable" not in compared
    page = (out / "report" / "index.html").read_text()
    assert "2 trials were left out: the arm cannot do their grasp without a collision" in page
    assert "infeasible: " in fails(capsys, "show", out, "--trial", "1", "--png", tmp_path / "a.png")
    assert main(["show", str(out), "--trial", "0", "--save", str(tmp_path / "t.rrd")]) == 0
    captured = capsys.readouterr()
    assert "warning" not in captured.err
    assert main(["grasps", str(out), "--out", str(tmp_path / "d.csv")]) == 0
    written = read_grasps(tmp_path / "d.csv")
    assert [e.confidence for e in written] == [float(held), None, None]
    assert written[1].object_yaw is None
    assert_same_grasps([far, inside], written[1:])


@pytest.fixture
def quick(monkeypatch):
    """Lifts take no time."""
    use_trial(monkeypatch, stand_ins.given)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "grasps.csv"
    write_grasps(entries(5), path)
    return path


def table(out):
    return (out / "trials.parquet").read_bytes()


def test_a_run_repeats_resumes_and_minds_changes(tmp_path, capsys, quick, file):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert lift("--grasps", file, "--trials", 3, "--out", whole, "--workers", 2) == 0
    assert lift("--grasps", file, "--trials", 1, "--out", parts) == 0
    same = ["lift", "--resume", "--out", parts]
    resume = [*same, "--trials", "3"]
    text = file.read_text()
    file.write_text(text.replace("0.", "0.0", 1))
    kept = table(parts)
    capsys.readouterr()
    changed = "has changed since the run began; bring the file back, or start a run"
    assert changed in fails(capsys, *resume)
    assert changed in fails(capsys, "show", parts, "--trial", "0")
    assert "grasp_set (run: sha256" in fails(capsys, *same, "--grasps", file)
    assert "grasps (run: file, asked: any)" in fails(capsys, *same, "--grasps", "any")
    assert table(parts) == kept
    file.write_text(text)

    moved = file.rename(tmp_path / "moved.csv")
    assert "No such file" in fails(capsys, *resume)
    assert main([*map(str, resume), "--grasps", str(moved)]) == 0
    assert "trial numbers move, each grasp now has 3 trials (it had 1)" in capsys.readouterr().err
    assert table(parts) == table(whole)
    assert "would drop some: give 3 or more" in fails(
        capsys, "lift", "--resume", "--trials", "2", "--out", parts
    )
    rows = read_rows(whole / "trials.parquet")
    box = [e.name for e in entries(5) if e.object == "box"]
    assert [row["grasp_name"] for row in rows[:9]] == box * 3
    assert [row["grasp_copy"] for row in rows[:9]] == [0] * 3 + [1] * 3 + [2] * 3


def test_a_dask_cluster_runs_the_same_trials(tmp_path, quick, file):
    pytest.importorskip("distributed", reason="the extra 'distributed' is not installed")
    here, there = tmp_path / "here", tmp_path / "there"
    assert lift("--grasps", file, "--out", here, "--workers", 1) == 0
    assert lift("--grasps", file, "--out", there, "--workers", 1, "--executor", "dask") == 0
    assert table(here) == table(there)


def test_errors_keep_the_name_of_the_grasp(tmp_path, monkeypatch, file):
    use_trial(monkeypatch, stand_ins.given_or_error)
    assert lift("--grasps", file, "--trials", 4, "--out", tmp_path / "out") == 0
    rows = read_rows(tmp_path / "out" / "trials.parquet")
    bad = [row for row in rows if row["failure"] == "error"]
    assert 0 < len(bad) < len(rows), "take another number of trials"
    assert all(row["grasp_name"] and row["grasp_copy"] is not None for row in bad)


def test_the_share_of_copies_that_held_is_written_as_confidence(tmp_path, quick, file, capsys):
    out, written = tmp_path / "out", tmp_path / "w.parquet"
    assert lift("--grasps", file, "--trials", 8, "--out", out) == 0
    assert main(["grasps", str(out), "--out", str(written)]) == 0
    rows = read_table(out / "trials.parquet", ["grasp_name", "success", "failure"]).to_pylist()
    for entry in read_grasps(written):
        mine = [r["success"] for r in rows if r["grasp_name"] == entry.name
                and r["failure"] != "unstable_simulation"]  # fmt: skip
        assert entry.confidence == sum(mine) / len(mine)
    assert len(read_grasps(written)) == 5


def test_the_objects_of_a_file_are_lifted_where_none_is_named(tmp_path, quick, file):
    assert lift("--grasps", file, "--out", tmp_path / "out") == 0
    plan = RunFolder(tmp_path / "out").read_plan()
    assert plan.objects == ("box", "oval_bottle")
    assert (plan.trials, plan.total) == (1, 5)
    assert plan.grasp_counts == {"box": 3, "oval_bottle": 2}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--grasps", "F", "--object", "box"], "is for 'oval_bottle'; the objects are box"),
        (["--grasps", "F", "--object", "all"], "the file has none of spray_bottle, cylindrical"),
        (["--grasps", "anny", "--object", "box"], "--grasps: got 'anny'; choose any or precision"),
        (["--grasps", "file", "--object", "box"], "--grasps: got 'file'; choose any or precision"),
        (["--grasps", "", "--object", "box"], "--grasps: got ''; choose any or precision"),
        (["--grasps", "no.csv", "--object", "box"], "--grasps: cannot read '"),
        (["--grasps", "F", "--preset", "paper"], "leave --grasps out"),
        (["--grasps", "F", "--trials", "0"], "--trials: got 0"),
    ],
)
def test_lift_refuses_in_one_line_and_writes_nothing(
    tmp_path, capsys, quick, file, arguments, says
):
    given = [str(file) if a == "F" else a for a in arguments]
    out = tmp_path / "out"
    assert says in fails(capsys, "lift", *given, "--out", out)
    assert not (out / "run.json").exists()
    assert not (out / "trials.parquet").exists()


def test_a_million_rows_are_refused_in_one_line(tmp_path, capsys, quick):
    path = tmp_path / "a.csv"
    text = "palm_x,palm_y,palm_z,palm_qw,palm_qx,palm_qy,palm_qz,preshape\n"
    path.write_text(text + "0,0,0.2,0,1,0,0,parallel\n" * 10**6)
    says = fails(capsys, "lift", "--object", "box", "--grasps", path, "--out", tmp_path / "out")
    assert "has more than 100000 grasps; split the file" in says
    assert not (tmp_path / "out").exists()


def test_grasps_refuses_in_one_line(tmp_path, capsys, run):
    out = tmp_path / "a.csv"
    assert "--grasps: got 'a.xls'; expected a name that ends in" in fails(
        capsys, "grasps", run, "--out", tmp_path / "a.xls"
    )
    assert "is not a folder" in fails(capsys, "grasps", tmp_path / "none", "--out", out)
    assert "--object: got 'mug'; " in fails(capsys, "grasps", run, "--object", "mug", "--out", out)
    # Stand-ins of random grasps have none.
    assert "has no finished trial with a grasp in its row; nothing was written" in fails(
        capsys, "grasps", run, "--out", out
    )
    assert not out.exists()


def test_run_json_says_which_file(tmp_path, quick, file):
    assert lift("--grasps", file, "--out", tmp_path / "out") == 0
    kept = json.loads((tmp_path / "out" / "run.json").read_text())
    assert kept["settings"]["grasps"] == "file"
    assert kept["settings"]["grasp_set"]["path"] == str(file)
    assert kept["grasp_counts"] == {"box": 3, "oval_bottle": 2}
