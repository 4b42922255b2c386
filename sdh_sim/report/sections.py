"""Sentences and tables of the report."""

from __future__ import annotations

import math

from sdh_sim.analysis.comparison import METRICS, name_of
from sdh_sim.analysis.study import EVERY, SEEN, Study
from sdh_sim.report import html
from sdh_sim.report.html import Cell

_SHOWN_TARGETS = (0.01, 0.02, 0.05, 0.10, 0.20, 0.25, 0.30)


def _pct(value: float | None) -> str:
    return html.DASH if value is None else f"{100 * value:.0f}\u00a0%"


def key_lines(study: Study) -> list[str]:
    """What the comparison says, in a few sentences."""
    first = study.findings[study.main, METRICS[0]].comparison
    lines = [
        f"{first.n} trials were compared, of which {first.success.k} "
        f"({_pct(first.success.value)}) held."
    ]
    for metric in study.metrics:
        finding = study.findings[study.main, metric]
        c, best = finding.comparison, finding.best
        if not c.has_boundary:
            continue
        text = f"{name_of(metric)} > {c.threshold:g}: {_pct(c.accuracy.value)} predicted rightly"
        if c.auc is not None:
            text += (
                f", {_pct(c.true_positive_rate.value)} of the successes found, "
                f"{_pct(c.false_positive_rate.value)} of the failures let through, area under "
                f"the ROC curve {c.auc:.2f}"
            )
        if best is not None and math.isfinite(best.threshold):
            text += (
                f". With the boundary chosen on other trials (about {best.threshold:.2f}): "
                f"{_pct(best.accuracy.value)}"
            )
        lines.append(text + ".")
    if first.missing:
        lines.append(f"{first.missing} trials without q* count as q* = 0, a predicted failure.")
    if first.unstable:
        lines.append(
            f"{first.unstable} trials were left out: their simulation was unstable or broke off."
        )
    if study.surplus:
        lines.append(f"{study.surplus} trials beyond the objects' shares were left out.")
    return lines


def rate_table(study: Study) -> str:
    """Confusion matrix and shares per object and metric."""
    rows, rules = [], []
    for group in study.groups:
        rules.append(len(rows))
        metrics = [m for m in study.metrics if m.startswith("q_")]
        for k, metric in enumerate(metrics):
            c = study.findings[group, metric].comparison
            rows.append(
                [
                    html.name(group) if k == 0 else "",
                    name_of(metric),
                    *(str(count) for count in (c.tp, c.fn, c.tn, c.fp)),
                    html.percent(c.accuracy),
                    html.percent(c.true_positive_rate),
                    html.percent(c.true_negative_rate),
                ]
            )
    return html.table(
        "Confusion matrix at the threshold 1: TP, FN are grasps that held and were predicted to, "
        "or not; TN, FP grasps that did not. Shares in percent with 95 % intervals.",
        ["object", "metric", "TP", "FN", "TN", "FP", "accuracy", "TPR", "TNR"],
        rows,
        text=(0, 1),
        rules=rules,
    )


def pair_lines(study: Study) -> list[str]:
    """Who is right where L-infinity and L1 disagree."""
    p = study.paired[study.main]
    lines = [
        f"They predict different ends for {p.disagree.k} of {p.n} grasps "
        f"({_pct(p.disagree.value)}): L∞ alone is right about {p.only_first_right} of these, L1 "
        f"alone about {p.only_second_right}; McNemar's exact p = {_p_value(p.p_value)}.",
    ]
    if p.first_optimistic.n:
        lines.append(
            f"L∞ alone predicts success for {p.first_optimistic.n} grasps, of which "
            f"{p.first_optimistic.k} held."
        )
    if p.second_optimistic.n:
        lines.append(
            f"L1 alone predicts success for {p.second_optimistic.n} grasps, of which "
            f"{p.second_optimistic.k} held."
        )
    if p.area_difference is not None and p.area_interval is not None:
        low, high = p.area_interval
        lines.append(
            f"The areas under their ROC curves differ by {p.area_difference:+.3f} "
            f"({low:+.3f} to {high:+.3f}): "
            + ("one ranks better." if low > 0 or high < 0 else "neither ranks better.")
        )
    return lines


def _p_value(p: float) -> str:
    return f"{p:.3f}" if p >= 0.001 else f"{p:.1e}"


def pair_table(study: Study) -> str:
    """Disagreement per object."""
    rows = []
    for group in study.groups:
        p = study.paired[group]
        rows.append(
            [
                html.name(group),
                str(p.n),
                html.percent(p.disagree),
                str(p.only_first_right),
                str(p.only_second_right),
                _p_value(p.p_value),
                html.number(p.area_difference, p.area_interval, 3),
            ]
        )
    return html.table(
        "Where L∞ and L1 disagree at the threshold 1 [%], who alone is right, McNemar's exact "
        "test, and the difference of the areas under the ROC curves (L∞ less L1).",
        ["object", "n", "disagree", "only L∞ right", "only L1 right", "p", "ΔAUC"],
        rows,
        rules=[len(rows) - 1] if len(rows) > 1 else [],
    )


def metric_table(study: Study) -> str:
    """Areas and the best threshold per object and metric."""
    rows, rules = [], []
    for group in study.groups:
        rules.append(len(rows))
        for k, metric in enumerate(study.metrics):
            finding = study.findings[group, metric]
            c, best, curve = finding.comparison, finding.best, finding.precision_recall
            rows.append(
                [
                    html.name(group) if k == 0 else "",
                    name_of(metric),
                    str(c.n),
                    html.number(c.auc, c.auc_interval),
                    html.number(curve.area, curve.area_interval) if curve else html.DASH,
                    html.percent(c.accuracy) if c.has_boundary else html.DASH,
                    _threshold(best.threshold, best.low, best.high) if best else html.DASH,
                    html.percent(best.accuracy) if best else html.DASH,
                ]
            )
    return html.table(
        "Areas under the ROC (AUC) and precision-recall (AP) curves; accuracy [%] at the "
        "threshold 1 and at the most accurate threshold, which is chosen by cross-validation "
        "(in brackets its range over the folds).",
        ["object", "metric", "n", "AUC", "AP", "at 1", "best threshold", "at best"],
        rows,
        text=(0, 1),
        rules=rules,
    )


def _threshold(value: float, low: float, high: float) -> Cell:
    return Cell(f"{value:.3g}", f"{low:.3g}–{high:.3g}" if low >= 0 else f"{low:.3g} to {high:.3g}")


def calibration_table(study: Study) -> str:
    """Threshold for some desired false positive rates."""
    rows, rules = [], []
    for metric in (m for m in study.metrics if m.startswith("q_")):
        c = study.findings[study.main, metric].calibration
        if c is None:
            continue
        rules.append(len(rows))
        for k, target in enumerate(c.targets):
            if round(float(target), 4) in _SHOWN_TARGETS:
                rows.append(
                    [
                        name_of(metric) if rules[-1] == len(rows) else "",
                        f"{100 * target:.0f} %",
                        _threshold(c.threshold[k], c.threshold_low[k], c.threshold_high[k]),
                        html.percent(c.achieved[k]),
                        Cell(
                            f"{100 * c.tpr[k]:.0f}",
                            f"{100 * c.tpr_low[k]:.0f}–{100 * c.tpr_high[k]:.0f}",
                        ),
                    ]
                )
    return html.table(
        "Threshold for a desired false positive rate over all trials; the rate on trials that "
        "did not choose it [%]; and the true positive rate that is left [%].",
        ["metric", "desired", "threshold", "held out", "TPR"],
        rows,
        rules=rules,
    )


def load_lines(study: Study) -> list[str]:
    """Which bound comes nearest to the load held."""
    metrics = list(study.load)
    known = {m: study.agreement[study.main, m, EVERY] for m in metrics}
    lines = []
    for metric, a in known.items():
        if a.median is None or a.spread is None or a.median_interval is None:
            continue
        low, high = (math.exp(v) for v in a.median_interval)
        side = "over" if a.median > 0 else "under"
        lines.append(
            f"{name_of(metric)} {side}estimates: median of q*/q_sim {math.exp(a.median):.2f} "
            f"({low:.2f} to {high:.2f}), spread a factor {math.exp(a.spread):.2f} either way."
        )
    bounded = {m: abs(a.median) for m, a in known.items() if a.median is not None}
    if bounded:
        nearest = min(bounded, key=lambda m: bounded[m])
        lines.append(f"By its median, {name_of(nearest)} is nearest to what the grasps hold.")
    any_one = known[metrics[0]]
    lines.append(
        f"The ratio is defined for {any_one.ratios} of {any_one.n} trials: {any_one.dropped} "
        f"grasps held no load at all though {name_of(metrics[0])} > 0, {any_one.zero} held some "
        f"though {name_of(metrics[0])} = 0, {any_one.capped} held the largest load tried."
    )
    return lines


def load_table(study: Study) -> str:
    """Agreement of every bound with the load test."""
    rows, rules = [], []
    for group in study.groups:
        for subset in (EVERY, SEEN) if group == study.main else (EVERY,):
            rules.append(len(rows))
            label = html.name(group) + ("" if subset == EVERY else ", pads see every contact")
            for k, metric in enumerate(study.load):
                a = study.agreement[group, metric, subset]
                bounds = a.median_interval
                factors = None if bounds is None else (math.exp(bounds[0]), math.exp(bounds[1]))
                rows.append(
                    [
                        label if k == 0 else "",
                        name_of(metric),
                        str(a.n),
                        html.number(a.spearman, a.spearman_interval),
                        str(a.ratios),
                        html.number(a.factor, factors),
                        html.number(None if a.spread is None else math.exp(a.spread)),
                        html.percent(a.below),
                    ]
                )
    return html.table(
        "q* against q_sim: Spearman's rank correlation over all trials; median of q*/q_sim and "
        "the factor that spans 68 % of the trials around it, where both are above 0; share of "
        "the trials in which the bound promises no more than the grasp held [%].",
        ["trials", "metric", "n", "rank corr.", "ratios", "q*/q_sim", "spread ×", "q* ≤ q_sim"],
        rows,
        text=(0, 1),
        rules=rules,
    )
