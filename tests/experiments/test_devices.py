"""Findings of the devices study against numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import devices
from experiments.devices import Seen


def seen(device: str, q: float, q_sim: float, held: bool = True, capped: bool = False) -> Seen:
    """A trial whose bounds are q, q / 2, q and q."""
    return Seen(device, held, np.array([q, q / 2, q, q, q_sim]), capped)


def test_ratios_count_every_grasp_that_gave_way():
    # Ratios of L∞: 2, 2, 0 (q* is 0), infinite (it bears nothing), 1 (both are 0), and one that is
    # left out: the largest load was held.
    trials = [
        seen("parallel_jaw", 4.0, 2.0), seen("parallel_jaw", 2.0, 1.0),
        seen("parallel_jaw", 0.0, 0.5, held=False), seen("parallel_jaw", 3.0, 0.0, held=False),
        seen("parallel_jaw", 0.0, 0.0, held=False), seen("parallel_jaw", 9.0, 20.0, capped=True),
    ]  # fmt: skip
    linf, l1, *_ = devices.findings(trials)
    assert sorted(linf.ratios) == [0.0, 1.0, 2.0, 2.0, np.inf]
    assert linf.ratio is not None
    assert l1.ratio is not None
    assert (linf.ratio.median, l1.ratio.median, linf.capped) == (2.0, 1.0, 1)
    assert linf.comparison.n == 6
    assert linf.comparison.tp == 3
    assert linf.comparison.fp == 1


def test_a_spread_of_a_factor():
    # Ratios 2^-1 … 2^1 evenly in the logarithm: 16 and 84 % are 0.34 either way of the middle.
    ratios = 2.0 ** np.linspace(-1, 1, 101)
    found = devices.findings([seen("schunk_sdh2", r, 1.0) for r in ratios])[0].ratio
    assert found is not None
    assert found.spread == pytest.approx(2.0**0.68, rel=1e-6)
    assert found.median == pytest.approx(1.0)
    low, high = found.median_interval
    assert 0.6 < low < 1.0 < high < 1.6


def test_the_study_runs_and_draws(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(devices, "PAPER_ORDER", ("box",))  # one object is enough to draw
    devices.main(["--trials", "1", "--seed", "5", "--out", str(tmp_path)])
    printed = capsys.readouterr().out
    assert "parallel jaw" in printed
    assert (tmp_path / "devices.svg").stat().st_size > 5000
