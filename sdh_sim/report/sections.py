"""Sections of the report: their figures with captions, their sentences and tables."""

from __future__ import annotations

from typing import Protocol

from matplotlib.figure import Figure

from sdh_sim.analysis.study import Study
from sdh_sim.report import figures, load_figures
from sdh_sim.report.dots import answering
from sdh_sim.report.figures import Reference
from sdh_sim.report.page import Bullets, Picture, Section
from sdh_sim.report.page_tables import (
    CALIBRATION_TABLE,
    METRIC_TABLE,
    RATE_TABLE,
    calibration_table,
    load_table,
    metric_table,
    moment_table,
    pair_table,
    rate_table,
)
from sdh_sim.report.sentences import key_sentences, load_sentences, pair_sentences


class Draw(Protocol):
    """Writes a figure: name of its files, the figure, its caption; numbers it for the page.

    ``numbers`` is the name of the table with the figure's numbers.
    """

    def __call__(self, name: str, figure: Figure, caption: str, numbers: str = "") -> Picture: ...


def sections_of(study: Study, draw: Draw, reference: Reference | None = None) -> list[Section]:
    """All sections, in the order of the page.

    Args:
        study: what to report.
        draw: writes the figures.
        reference: published numbers to draw beside the study's own.
    """
    found = [
        Section("In short", [Bullets(key_sentences(study))]),
        _distribution(study, draw),
        _threshold_1(study, draw, reference),
        Section("L∞ against L1", [Bullets(pair_sentences(study)), pair_table(study)]),
        _all_thresholds(study, draw, reference),
    ]
    if any(finding.calibration for finding in study.findings.values()):
        found.append(_calibration(study, draw))
    if study.moments:
        found.append(Section("Before the lift and when the table has gone", [moment_table(study)]))
    return [*found, _load(study, draw)] if study.load else found


def _distribution(study: Study, draw: Draw) -> Section:
    beside = " Dots: the single grasps." if answering(study.cases) else ""
    picture = draw(
        "boxes",
        figures.boxes(study),
        "Task scaling of every grasp before the lift, for grasps that held (full) and that did "
        "not (hollow). Boxes: quartiles and median; whiskers: the last trial within 1.5 "
        "interquartile ranges. Dashed: the decision boundary 1. Grasps that cannot exert the task "
        "at all are drawn at 0, values beyond the axis at its end." + beside,
    )
    return Section("Distribution of the metric", [picture])


def _threshold_1(study: Study, draw: Draw, reference: Reference | None) -> Section:
    beside = " Diamonds: published numbers of the real grasps." if reference else ""
    picture = draw(
        "rates",
        figures.rates(study, reference),
        "Share of the trials predicted rightly, of the successes predicted, and of the failures "
        "predicted, with 95 % Wilson intervals." + beside,
        RATE_TABLE,
    )
    return Section("Prediction with the threshold 1", [picture, rate_table(study)])


def _all_thresholds(study: Study, draw: Draw, reference: Reference | None) -> Section:
    roc = draw(
        "roc",
        figures.roc(study, reference),
        "Receiver operating characteristic over all trials, 95 % bands of L∞ and L1.",
        METRIC_TABLE,
    )
    precision_recall = draw(
        "precision_recall",
        figures.precision_recall(study),
        "Precision over recall. Dashed: share of all trials that succeeded.",
        METRIC_TABLE,
    )
    return Section("All thresholds", [roc, precision_recall, metric_table(study)])


def _calibration(study: Study, draw: Draw) -> Section:
    picture = draw(
        "calibration",
        load_figures.calibration(study),
        "(a) The smallest threshold that lets through no more than the desired share of the "
        "failing grasps. (b) The share of the successful grasps that is still predicted at it. "
        "(c) The share of failing grasps that passes when the threshold was chosen on other "
        "trials.",
        CALIBRATION_TABLE,
    )
    return Section("As conservative as desired", [picture, calibration_table(study)])


def _load(study: Study, draw: Draw) -> Section:
    scatter = draw(
        "load_scatter",
        load_figures.load_scatter(study),
        "The bound's promise q* against the load q_sim at which the object gave way in "
        "simulation, one dot a trial; on the dashed line the bound is exact, above it too "
        "optimistic; ρ is the rank correlation. Hollow: something that no pad feels bears load as "
        "well. The axes are linear up to 1, then logarithmic; what lies beyond is drawn at the "
        "edge.",
    )
    ratio = draw(
        "load_ratio",
        load_figures.load_ratio(study),
        "By what factor each bound over- or underestimates the load that the grasp holds.",
    )
    parts = [Bullets(load_sentences(study)), scatter, ratio, load_table(study)]
    return Section("What the grasp really holds", parts)
