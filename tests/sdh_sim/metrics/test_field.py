"""The list of all metrics, and what can be asked for."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.errors import SettingsError
from sdh_sim.metrics import METRICS
from sdh_sim.metrics.field import KNOWN, LITERATURE, OWN, chosen, of_function
from sdh_sim.metrics.field_metric import FAMILIES

FILE = """
def spread(grasp):
    return 1.0

def q_linf(grasp):
    return 1.0

spread.high_is_good = False
spread.threshold = 2.0
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(FILE)
    return path


def test_every_metric_says_what_a_reader_needs():
    assert len(KNOWN) == len(OWN) + len(LITERATURE)  # no name twice
    assert {metric.name for metric in OWN} == set(METRICS)
    for metric in KNOWN.values():
        assert metric.family in FAMILIES
        assert metric.name.isidentifier()
        assert metric.label
        assert metric.source
        assert metric.conventions
        assert metric.blind_to
    assert len({metric.label for metric in KNOWN.values()}) == len(KNOWN)


def test_what_can_be_asked_for(file):
    assert chosen(["all"]) == (tuple(KNOWN), ())
    assert chosen(["field"])[0] == tuple(metric.name for metric in LITERATURE)
    known, own = chosen(["q_l1,q_linf", f"{file}:spread", "q_l1"])
    assert (known, [metric.name for metric in own]) == (("q_l1", "q_linf"), ["spread"])


@pytest.mark.parametrize(
    ("asked", "word"),
    [("nonsense", "nonsense"), ("missing.py:f", "cannot be loaded"), ("a:b c", "function's name")],
)
def test_what_there_is_not_is_refused(asked, word):
    with pytest.raises(SettingsError, match=word):
        chosen([asked])


def test_two_metrics_of_one_name_are_refused(file, tmp_path):
    with pytest.raises(SettingsError, match="two of the name q_linf"):
        chosen([f"{file}:q_linf"])
    other = tmp_path / "other.py"
    other.write_text(FILE)
    with pytest.raises(SettingsError, match="two of the name spread"):
        chosen([f"{file}:spread", f"{other}:spread"])


def test_a_function_says_its_orientation_and_threshold():
    def spread(grasp):
        return float(np.nan)

    plain = of_function(spread)
    assert (plain.name, plain.high_is_good, plain.threshold) == ("spread", True, None)
    spread.high_is_good, spread.threshold = False, 2  # type: ignore[attr-defined]
    found = of_function(spread)
    assert (found.high_is_good, found.threshold, found.worst) == (False, 2, np.inf)
    with pytest.raises(SettingsError, match="name"):
        of_function(lambda grasp: 1.0)
