"""Every way to ask ``lift`` for what it cannot do: one line, exit status 2, nothing written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from sdh_sim.cli.app import main
from sdh_sim.records import read_rows
from tests.support.command_line import LIFT, fails


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--object", "duck"], "--object: got 'duck'; choose one of box,"),
        (["--trials", "0"], "--trials: got 0; allowed is a whole number 1 to"),
        (["--trials", "-3"], "--trials: got -3"),
        (["--trials", "many"], "'--trials'"),
        (["--trials", "2.5"], "'--trials'"),
        (["--seed", "-1"], "--seed: got -1"),
        (["--workers", "0"], "--workers: got 0; give a whole number of at least 1"),
        (["--workers", "-2"], "--workers: got -2"),
        (["--torque-limit", "0", "1"], "--torque-limit: got (0.0, 1.0)"),
        (["--torque-limit", "1", "-1"], "--torque-limit: got (1.0, -1.0)"),
        (["--torque-limit", "nan", "1"], "--torque-limit: got (nan, 1.0)"),
        (["--torque-limit", "inf", "1"], "--torque-limit: got (inf, 1.0)"),
        (["--torque-limit", "1"], "--torque-limit"),
        (["--sensor", "eye"], "--sensor: got 'eye'; choose one of dsa, ideal"),
        (["--pads", "none"], "--pads: got 'none'; the hand schunk_sdh2 has all, proximal, distal"),
        (["--rerun", "some"], "--rerun: got 'some'; choose one of all, failures, none"),
        (["--resume", "--overwrite"], "exclude each other"),
        (["--retry-errors"], "give --resume with it"),
        (["--executor", "cloud"], "--executor: got 'cloud'; choose one of processes, dask"),
        (["--scheduler", "tcp://h:1"], "--scheduler: got 'tcp://h:1'; it needs --executor dask"),
        (["--preset", "slow"], "--preset: got 'slow'; choose one of paper, fast"),
        (["--preset", "paper"], "--preset paper decides objects and trials itself"),
        (["--timestep", "1"], "--timestep: got 1.0; allowed is 0.0001 to 0.005 s"),
        (["--repeats", "1001"], "--repeats: got 1001; allowed is 0 to 1000"),
        (["--pad-thickness", "0.01"], "--pad-thickness"),
        (["--colour", "red"], "--colour"),
        (["extra"], "extra"),
    ],
)
def test_lift_refuses_in_one_line_and_writes_nothing(tmp_path, capsys, options, words):
    out = tmp_path / "out"
    assert words in fails(capsys, *LIFT, out, *options)
    assert not out.exists()


def test_lift_wants_out_and_an_object(tmp_path, capsys):
    assert "--out" in fails(capsys, "lift", "--object", "box")
    assert "--object: missing; give one of box," in fails(capsys, "lift", "--out", tmp_path / "x")
    assert "empty" in fails(capsys, *LIFT, "")


def test_an_out_that_cannot_be_written(tmp_path, capsys, quick):
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/nowhere")):
        line = fails(capsys, *LIFT, out)
        assert f"cannot write to {out}" in line
        assert "choose another --out" in line
    assert "it is a file, not a folder" in fails(capsys, *LIFT, tmp_path / "file")
    assert (tmp_path / "file").read_text() == ""
    assert "too long" in fails(capsys, *LIFT, tmp_path / ("x" * 300))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_out(tmp_path, capsys, quick):
    tmp_path.chmod(0o500)
    assert "Permission denied" in fails(capsys, *LIFT, tmp_path / "out")


def test_an_out_that_holds_a_run(run, capsys, quick):
    before = (run / "trials.parquet").read_bytes()
    line = fails(capsys, *LIFT, run)
    assert f"{run} already holds a run" in line
    assert "--resume" in line
    assert "--overwrite" in line
    assert (run / "trials.parquet").read_bytes() == before


@pytest.mark.parametrize("name", ["trials.parquet", "run.json"])
def test_a_damaged_run_is_refused_untouched(run, capsys, quick, name):
    other = next(n for n in ("trials.parquet", "run.json") if n != name)
    (run / name).write_bytes(b"\x00\x01 not this")
    before = (run / other).read_bytes()
    line = fails(capsys, "lift", "--resume", "--out", run)
    assert name in line
    assert "--overwrite" in line
    assert (run / name).read_bytes() == b"\x00\x01 not this"
    assert (run / other).read_bytes() == before
    fails(capsys, "show", run, "--trial", "0")
    if name == "trials.parquet":
        assert "not a readable parquet file" in fails(capsys, "compare", run)
    assert main([*LIFT, str(run), "--overwrite", "--trials", "1"]) == 0
    assert len(read_rows(run / "trials.parquet")) == 1


def test_resume_with_another_setting_is_refused_by_name(run, capsys, quick):
    line = fails(capsys, "lift", "--resume", "--out", run, "--torque-limit", "1", "1")
    assert "torque_limit (run: 1.6401 1.0934, asked: 1.0 1.0)" in line
    line = fails(capsys, "lift", "--resume", "--out", run, "--object", "oval_bottle")
    assert "objects (run: box, asked: oval_bottle)" in line
    line = fails(capsys, "lift", "--resume", "--out", run, "--trials", "2")
    assert "--trials 2 would drop some: give 3 or more" in line
