"""Tables of the report's page."""

from __future__ import annotations

from sdh_sim.analysis.comparison import name_of
from sdh_sim.analysis.moments import MOMENTS
from sdh_sim.analysis.roc_area import AreaDifference
from sdh_sim.analysis.study import EVERY, HELD, LOST, SEEN, Study
from sdh_sim.report.page import Table
from sdh_sim.report.table_cells import (
    DASH,
    TableCell,
    number,
    object_name,
    p_value,
    percent,
    threshold,
)

_SUBSETS = {
    EVERY: "",
    HELD: ", held in the lift",
    LOST: ", not held",
    SEEN: ", pads see every contact",
}
# Names of tables that figures refer to.
RATE_TABLE, METRIC_TABLE, CALIBRATION_TABLE = "rates-table", "metrics-table", "calibration-table"

_SHOWN_TARGETS = (0.01, 0.02, 0.05, 0.10, 0.20, 0.25, 0.30)  # desired false positive rates


def rate_table(study: Study) -> Table:
    """Confusion matrix and rates per object and metric."""
    rows, rules = [], []
    for group in study.groups:
        rules.append(len(rows))
        metrics = [m for m in study.metrics if m.startswith("q_")]
        for k, metric in enumerate(metrics):
            c = study.findings[group, metric].comparison
            rows.append(
                [
                    object_name(group) if k == 0 else "",
                    name_of(metric),
                    *(str(count) for count in (c.n, c.tp, c.fn, c.tn, c.fp)),
                    percent(c.accuracy),
                    percent(c.true_positive_rate),
                    percent(c.true_negative_rate),
                ]
            )
    return Table(
        "Confusion matrix at the threshold 1: TP, FN are grasps that held and were predicted to, "
        "or not; TN, FP grasps that did not; n is their sum. Shares in percent, 95 % intervals.",
        ["object", "metric", "n", "TP", "FN", "TN", "FP", "accuracy", "TPR", "TNR"],
        rows,
        text_columns=(0, 1),
        ruled_rows=rules,
        name=RATE_TABLE,
    )


def pair_table(study: Study) -> Table:
    """Where L-infinity and L1 disagree, per object."""
    rows = []
    for group in study.groups:
        p = study.paired[group]
        rows.append(
            [
                object_name(group),
                str(p.n),
                percent(p.disagree),
                str(p.only_first_right),
                str(p.only_second_right),
                p_value(p.p_value),
                _difference(p.areas),
            ]
        )
    return Table(
        "Where L∞ and L1 disagree at the threshold 1 [%], who alone is right, McNemar's exact "
        "test, and the difference of the areas under the ROC curves (L∞ less L1, interval and test "
        "by DeLong).",
        ["object", "n", "disagree", "only L∞ right", "only L1 right", "p", "ΔAUC"],
        rows,
        ruled_rows=[len(rows) - 1] if len(rows) > 1 else [],
    )


def metric_table(study: Study) -> Table:
    """Areas under the curves and most accurate threshold, per object and metric."""
    rows, rules = [], []
    for group in study.groups:
        rules.append(len(rows))
        for k, metric in enumerate(study.metrics):
            finding = study.findings[group, metric]
            c, best, curve = finding.comparison, finding.best, finding.precision_recall
            rows.append(
                [
                    object_name(group) if k == 0 else "",
                    name_of(metric),
                    str(c.n),
                    number(c.auc, c.auc_interval),
                    number(curve.area, curve.area_interval) if curve else DASH,
                    percent(c.accuracy) if c.has_boundary else DASH,
                    threshold(best.threshold, best.low, best.high) if best else DASH,
                    percent(best.accuracy) if best else DASH,
                ]
            )
    return Table(
        "Areas under the ROC (AUC) and precision-recall (AP) curves; accuracy [%] at the "
        "metric's own threshold (q*: 1) and at the most accurate one. The threshold shown is the "
        "most accurate on all n trials (in brackets the range of those chosen on nine tenths of "
        "them); its accuracy is on the trials that did not choose it. Of a metric that has no "
        "value for some trials n is smaller: these are left out, not counted as 0.",
        ["object", "metric", "n", "AUC", "AP", "at own", "best threshold", "at best"],
        rows,
        text_columns=(0, 1),
        ruled_rows=rules,
        name=METRIC_TABLE,
    )


def _difference(areas: AreaDifference | None) -> TableCell:
    return TableCell(DASH) if areas is None else number(areas.value, areas.interval, 3)


def moment_table(study: Study) -> Table:
    """Every q* before the lift and at later moments."""
    rows, rules = [], []
    for m in study.moments:
        if not rows or rows[-1][1] != MOMENTS[m.moment]:
            rules.append(len(rows))
        pair = m.before, m.after
        rows.append(
            [
                name_of(m.before.metric),
                MOMENTS[m.moment],
                str(m.before.n),
                *(number(c.auc, c.auc_interval) for c in pair),
                _difference(m.paired.areas),
                *(percent(c.accuracy) for c in pair),
                *(percent(c.false_positive_rate) for c in pair),
                p_value(m.paired.p_value),
            ]
        )
    return Table(
        "The same metrics on the same trials from the snapshot on the table (before) and later: "
        "from a snapshot taken when the object has left it (at lift-off), or from where settling "
        "predicts that it comes to rest, 0 where it does not (where it settles): area under the "
        "ROC curve, its difference with DeLong's interval, accuracy and false positive rate at the "
        "threshold 1 [%], and p of McNemar's exact test that both are right equally often.",
        [
            *("metric", "later", "n", "AUC before", "later", "ΔAUC"),
            *("accuracy before", "later", "FPR before", "later", "p"),
        ],
        rows,
        text_columns=(0, 1),
        ruled_rows=rules,
    )


def calibration_table(study: Study) -> Table:
    """Threshold for some desired false positive rates, per metric."""
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
                        threshold(c.threshold[k], c.threshold_low[k], c.threshold_high[k]),
                        percent(c.achieved[k]),
                        TableCell(
                            f"{100 * c.tpr[k]:.0f}",
                            f"{100 * c.tpr_low[k]:.0f}–{100 * c.tpr_high[k]:.0f}",
                        ),
                    ]
                )
    return Table(
        "Threshold for a desired false positive rate over all trials; the rate on trials that "
        "did not choose it [%]; and the true positive rate that is left [%].",
        ["metric", "desired", "threshold", "held out", "TPR"],
        rows,
        ruled_rows=rules,
        name=CALIBRATION_TABLE,
    )


def load_table(study: Study) -> Table:
    """Agreement of every bound with the load test, per object."""
    rows, rules = [], []
    for group in study.groups:
        for subset in _SUBSETS if group == study.main else (EVERY,):
            rules.append(len(rows))
            label = object_name(group) + _SUBSETS[subset]
            for k, metric in enumerate(study.load):
                a = study.agreement[group, metric, subset]
                ratio = a.ratio
                rows.append(
                    [
                        label if k == 0 else "",
                        name_of(metric),
                        str(a.n),
                        number(a.spearman, a.spearman_interval),
                        *(str(k) for k in (a.capped, a.both, a.zero, a.dropped, a.neither)),
                        number(ratio.median, ratio.median_interval) if ratio else DASH,
                        number(ratio.spread) if ratio else DASH,
                        percent(a.below),
                    ]
                )
    return Table(
        "q* against q_sim: Spearman's rank correlation over all n trials, which are: those that "
        "held the largest load tried (capped), and of those that gave way the ones where both "
        "loads are above 0, q* alone is 0, q_sim alone is 0, both are 0; median of q*/q_sim over "
        "all that gave way, 0 and infinity included, and the factor that spans 68 % of them around "
        "it; share of the trials in which the bound promises no more than the grasp held [%].",
        [
            *("trials", "metric", "n", "rank corr.", "capped", "both", "q* 0", "q_sim 0", "both 0"),
            *("q*/q_sim", "spread ×", "q* ≤ q_sim"),
        ],
        rows,
        text_columns=(0, 1),
        ruled_rows=rules,
    )
