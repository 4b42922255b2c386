"""The command lines of the metric studies: short runs and one-line errors."""

import subprocess
import sys

import pytest

from tests.support.repository import ROOT


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", *arguments], cwd=ROOT, capture_output=True, text=True, timeout=180
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ("experiments.table1", "--grasps", "0"),
        ("experiments.table1", "--objects", "teapot"),
        ("experiments.table1", "--seed", "-1"),
        ("experiments.table1", "--reference", "nowhere.npz"),
        ("experiments.table1", "--out", "pyproject.toml"),
        ("experiments.table1", "--grasps", "many"),
        ("experiments.benchmarks.metrics", "--hulls", "0"),
        ("experiments.benchmarks.metrics", "--fast"),
    ],
)
def test_bad_command_lines_say_what_is_wrong_in_one_line(arguments):
    result = run(*arguments)
    assert result.returncode == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert result.stdout == ""


def test_table1_prints_both_bounds_and_draws_figure_6(tmp_path):
    result = run("experiments.table1", "--grasps", "12", "--objects", "box", "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert "L∞ paper" in result.stdout
    assert "force closure" in result.stdout
    assert (tmp_path / "figure6.png").stat().st_size > 5000
