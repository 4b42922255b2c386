"""The report: its numbers, a page that needs no other file, and writes that the disk refuses."""

from __future__ import annotations

import base64
import csv
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from sdh_sim.analysis import comparison as compare
from sdh_sim.analysis.study import read_study
from sdh_sim.cli.app import main
from sdh_sim.metrics import built_in as metrics
from sdh_sim.records import write_rows
from sdh_sim.records.settling_columns import SETTLING
from sdh_sim.report import figure_style, load_figures, write_report

FEW = 50


def rows(count: int = 24) -> list[dict]:
    """Load-tested trials on two objects, whose metrics grow with the load held."""
    rng = np.random.default_rng(7)
    found = []
    for k in range(count):
        load = float(rng.uniform(0, 3)) if k % 5 else 0.0
        q = max(0.0, load * 1.2 + float(rng.normal(0, 0.4)))
        failure = "none" if load > 1.2 else "slipped"
        found.append(
            {
                "trial": k,
                "object": ("box", "oval_bottle")[k % 2],
                "seed": k,
                "success": failure == "none",
                "failure": failure,
                "q_linf": q,
                "q_l1": 0.45 * q,
                "q_capability": 0.9 * q,
                "q_held": q if k % 7 else -np.inf,
                "epsilon_linf": 0.1 * q,
                "epsilon_l1": 0.05 * q,
                "volume_linf": 10 * q if k % 6 else None,
                "volume_l1": q if k % 6 else None,
                "q_sim": load,
                "q_sim_capped": False,
                "unsensed_contact": k % 3 == 0,
            }
        )
    return found


@pytest.fixture
def run(tmp_path) -> Path:
    folder = tmp_path / "run"
    folder.mkdir()
    write_rows(rows(), folder / "trials.parquet")
    return folder


def study(run: Path, metrics=compare.ALL_METRICS):
    return read_study([run / "trials.parquet"], metrics, FEW)


@pytest.fixture(scope="module")
def reported(tmp_path_factory) -> Path:
    """A report of every metric, not to be changed."""
    folder = tmp_path_factory.mktemp("reported")
    write_rows(rows(), folder / "trials.parquet")
    write_report(study(folder), folder / "report", "a <run> & more")
    return folder / "report"


def test_all_metrics_are_those_of_a_trial():
    # And the load of settling, where a run asked for it.
    assert set(compare.ALL_METRICS) == {*metrics.METRICS, "q_settled"}
    assert set(compare.NAMES) == set(compare.ALL_METRICS)


def test_every_metric_has_its_own_colour_and_text():
    assert set(figure_style.COLOURS) == set(figure_style.TEXTS) == set(compare.ALL_METRICS)
    assert len(set(figure_style.COLOURS.values())) == len(compare.ALL_METRICS)


def test_the_load_of_settling_is_drawn_too(run):
    path = run / "trials.parquet"
    added = [SETTLING["q_settled"]]
    write_rows(({**r, "q_settled": r["q_sim"]} for r in rows()), path, added)
    found = study(run, ("q_linf", "q_l1", "q_settled"))
    assert "q_settled" in found.load
    for draw in (load_figures.load_scatter, load_figures.load_ratio):
        colours = {line.get_color() for axes in draw(found).axes for line in axes.lines}
        assert figure_style.COLOURS["q_settled"] in colours


def test_the_page_stands_alone(reported):
    page = (reported / "index.html").read_text()
    assert "a &lt;run&gt; &amp; more" in page
    pictures = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)
    assert len(pictures) == 7
    bare = re.sub(r'src="data:[^"]+"', "", page)
    assert not re.search(r"https?:|//|src=|<script[^>]|<link|@import|url\(|fetch\(", bare)
    assert bare.count("<script>") == 1
    for picture in pictures:
        svg = base64.b64decode(picture).decode()
        links = re.findall(r'(?:href|src)="([^"]*)"', svg) + re.findall(r"url\(([^)]*)\)", svg)
        assert links
        assert all(link.startswith("#") for link in links)


def test_names_from_a_file_are_text(run):
    named = ({**r, "object": ("<script>x</script>", "a & b")[r["trial"] % 2]} for r in rows())
    write_rows(named, run / "trials.parquet")
    page = write_report(study(run, compare.METRICS), run / "report", "").read_text()
    assert page.count("<script") == 1  # the page's own
    assert "&lt;script&gt;x&lt;/script&gt;</td>" in page
    assert "a &amp; b</td>" in page


def test_every_figure_is_there_as_svg_and_png(reported):
    names = {p.stem for p in reported.glob("*.svg")}
    assert names == {
        *("boxes", "rates", "roc", "precision_recall", "calibration"),
        *("load_scatter", "load_ratio"),
    }
    for name in names:
        image = np.asarray(Image.open(reported / f"{name}.png").convert("L"))
        assert image.shape[0] > 300
        assert 0.002 < (image < 250).mean() < 0.5  # something is drawn, on white


def test_tables_as_csv_and_parquet_say_the_same(reported):
    for name in ("summary", "pairs", "calibration", "curves", "load"):
        table = pq.read_table(reported / f"{name}.parquet")
        with open(reported / f"{name}.csv", newline="") as file:
            lines = list(csv.DictReader(file))
        assert len(lines) == table.num_rows
        assert list(lines[0]) == table.column_names
        for line, row in zip(lines[:5], table.to_pylist()[:5], strict=True):
            assert line == {k: "" if v is None else str(v) for k, v in row.items()}


def test_summary_counts_by_hand(reported):
    table = pq.read_table(reported / "summary.parquet").to_pylist()
    (line,) = (r for r in table if (r["object"], r["metric"]) == ("overall", "q_l1"))
    data = rows()
    assert line["tp"] == sum(r["success"] and r["q_l1"] > 1 for r in data)
    assert line["fp"] == sum(not r["success"] and r["q_l1"] > 1 for r in data)
    assert line["true_negative_rate"] == line["tn"] / (line["tn"] + line["fp"])
    (volume,) = (r for r in table if (r["object"], r["metric"]) == ("overall", "volume_l1"))
    assert (volume["n"], volume["missing_metric"], volume["accuracy"]) == (20, 4, None)
    load = pq.read_table(reported / "load.parquet").to_pylist()
    (every,) = (
        r for r in load if (r["object"], r["metric"], r["trials"]) == ("overall", "q_linf", "all")
    )
    ratios = [
        r["q_linf"] / r["q_sim"] if r["q_sim"] > 0 else np.inf if r["q_linf"] > 0 else 1.0
        for r in data
    ]
    assert (every["n"], every["ratios"]) == (24, 24)
    assert every["median_ratio"] in sorted(ratios)[11:13]


def test_the_same_trials_give_the_same_bytes(run, reported):
    first, second = reported, run / "b"
    write_report(study(run), second, "a <run> & more")
    names = sorted(p.name for p in first.iterdir())
    assert names == sorted(p.name for p in second.iterdir())
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


def test_a_refused_write_leaves_the_old_page(run, reported, monkeypatch):
    shutil.copytree(reported, run / "report")
    page = run / "report" / "index.html"
    before = page.read_bytes()
    real = os.replace

    def refuse(source, target):
        if str(target).endswith("index.html"):
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="No space"):
        write_report(study(run, compare.METRICS), run / "report", "new")
    assert page.read_bytes() == before
    assert not list((run / "report").glob("*.tmp"))


def test_what_no_longer_belongs_is_removed(run, reported):
    shutil.copytree(reported, run / "report")
    (run / "report" / "mine.txt").write_text("keep")
    write_rows(({**r, "q_sim": None, "q_sim_capped": None} for r in rows()), run / "trials.parquet")
    page = write_report(study(run, compare.METRICS), run / "report", "").read_text()
    assert not list((run / "report").glob("load*"))
    assert (run / "report" / "mine.txt").exists()
    assert "q_sim" not in page


@pytest.mark.parametrize("kept", [slice(0, 1), slice(0, 2), slice(1, 24, 2)])
def test_few_trials_of_one_object_or_outcome(run, kept):
    some = [{**r, "success": True, "failure": "none"} for r in rows()][kept]
    write_rows(some, run / "trials.parquet")
    page = write_report(study(run), run / "report", "").read_text()
    assert f"{len(some)} trials were compared" in page
    assert "nan" not in page.lower()


def test_surplus_trials_are_left_out(run, tmp_path, capsys):
    path = run / "trials.parquet"
    write_rows(({**r, "surplus": r["trial"] >= 10} for r in rows()), path)
    some = read_study([path], resamples=FEW)
    assert (some.surplus, some.read) == (14, 24)
    assert some.findings["overall", "q_linf"].comparison.n == 10
    # An older table, from before there were presets, beside it.
    older = tmp_path / "older.parquet"
    pq.write_table(pq.read_table(path).drop_columns(["surplus"]), older)
    both = read_study([path, older], resamples=FEW)
    assert (both.surplus, both.read) == (14, 48)
    assert both.findings["overall", "q_linf"].comparison.n == 34
    assert main(["compare", str(path)]) == 0
    assert "14 trials beyond the objects' shares are left out" in capsys.readouterr().out


def test_published_numbers_are_drawn_and_further_sections_come_in(run):
    from sdh_sim.report.page import Section

    def extra(draw):
        from sdh_sim.report import figures

        return [Section("More", (draw("again", figures.roc(found), "Once more."),))]

    found = study(run, compare.METRICS)
    reference = {("overall", "q_linf"): {"accuracy": 0.745, "auc": 0.82}}
    page = write_report(found, run / "report", "", reference, extra).read_text()
    assert "<h2>More</h2>" in page
    assert "<b>Figure 8.</b> Once more." in page
    assert "Diamonds: published" in page
    assert (run / "report" / "again.png").exists()


def test_compare_writes_the_report_into_the_run(run, capsys):
    assert main(["compare", str(run)]) == 0
    printed = capsys.readouterr().out
    assert f"report: {run / 'report' / 'index.html'}" in printed
    assert (run / "report" / "index.html").exists()
    assert "q* held" not in printed
    assert "L∞ and L1 disagree on" in printed
    assert "rank corr." in printed


def test_compare_all_and_elsewhere(run, tmp_path, capsys):
    assert main(["compare", str(run), "--all", "--report", str(tmp_path / "x" / "y")]) == 0
    printed = capsys.readouterr().out
    for metric, name in compare.NAMES.items():
        assert (name in printed) == (metric != "q_settled")
    assert "ε and V have units" in printed
    assert (tmp_path / "x" / "y" / "index.html").exists()
    assert not (run / "report").exists()


def test_compare_without_a_report(run, capsys):
    assert main(["compare", str(run), "--no-report"]) == 0
    assert "report" not in capsys.readouterr().out
    assert not (run / "report").exists()


def test_several_runs_need_a_place(run, tmp_path, capsys):
    other = tmp_path / "other.parquet"
    write_rows([{**row, "seed": row["seed"] + 1000} for row in rows(10)], other)
    assert main(["compare", str(run), str(other)]) == 0
    assert "give --report FOLDER" in capsys.readouterr().out
    assert main(["compare", str(run), str(other), "--report", str(tmp_path / "r")]) == 0
    page = (tmp_path / "r" / "index.html").read_text()
    assert "Runs run, other.parquet: 34 trials compared" in page


def test_a_place_that_cannot_be_written(run, capsys):
    assert main(["compare", str(run), "--report", str(run / "trials.parquet" / "x")]) == 2
    assert "choose another --report" in capsys.readouterr().err
