"""A small form of the measurement of scale, and the query of the page about it."""

from __future__ import annotations

import pytest

from experiments.benchmarks import scale
from sdh_sim.analysis.study import read_study
from sdh_sim.objects import object_names
from sdh_sim.records import read_rows
from tests.support.repository import ROOT

TRIALS = 200


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run that was stopped in the middle, and what was measured of it."""
    out = tmp_path_factory.mktemp("scale") / "run"
    return out, scale.measure(out, TRIALS, "processes", 2)


def test_a_run_that_was_stopped_goes_on_to_all_of_its_rows(run):
    out, found = run
    rows = read_rows(out / "trials.parquet")
    assert [row["trial"] for row in rows] == list(range(TRIALS))
    assert len(found.memory) >= scale.MARKS - 1  # the stop may swallow one
    assert max(found.memory) < 2 * min(found.memory)
    assert min(found.rows_per_second) > 5.0
    assert 0.0 < found.resume < 10.0


def test_the_query_of_the_page_gives_the_numbers_of_the_comparison(run):
    duckdb = pytest.importorskip("duckdb", reason="the query of the page is DuckDB's")
    out, _ = run
    page = (ROOT / "docs" / "scale.md").read_text(encoding="utf-8")
    query = page.partition("```sql\n")[2].partition("```")[0]
    assert "'runs/*/trials.parquet'" in query
    query = query.replace("runs/*/trials.parquet", str(out.parent / "*" / "trials.parquet"))
    study = read_study([out / "trials.parquet"], resamples=20)
    rows = duckdb.sql(query).fetchall()
    assert {row[0] for row in rows} == set(object_names())
    for name, n, accuracy, positives, negatives, auc in rows:
        wanted = study.findings[name, "q_linf"].comparison
        assert n == wanted.n
        assert accuracy == pytest.approx(wanted.accuracy.value)
        assert positives == pytest.approx(wanted.true_positive_rate.value)
        assert negatives == pytest.approx(wanted.false_positive_rate.value)
        assert auc == pytest.approx(wanted.auc)
