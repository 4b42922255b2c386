"""What the report says in sentences."""

from __future__ import annotations

import math

from sdh_sim.analysis.comparison import METRICS, name_of
from sdh_sim.analysis.study import EVERY, Study
from sdh_sim.report.table_cells import DASH, p_value, signed

SURE = 0.95  # share of resamples in which a finding must hold to be told as one


def _pct(value: float | None) -> str:
    return DASH if value is None else f"{100 * value:.0f}\u00a0%"


def key_sentences(study: Study) -> list[str]:
    """The comparison over all trials in short."""
    first = study.findings[study.main, METRICS[0]].comparison
    lines = [
        f"{study.compared} trials were compared, of which {first.success.k} "
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
    if first.no_contact:
        shares = ", ".join(
            f"{name_of(m)} {_pct(c.accuracy_touching.value)}"
            for m in study.metrics
            if (c := study.findings[study.main, m].comparison).has_boundary
        )
        lines.append(
            f"In {first.no_contact} of them the hand did not touch the object, which any metric "
            f"predicts; without them predicted rightly: {shares}."
        )
    if first.unstable:
        lines.append(
            f"{first.unstable} trials were left out: their simulation was unstable or broke off."
        )
    if first.infeasible:
        lines.append(
            f"{first.infeasible} trials were left out: the arm cannot do their grasp without a "
            "collision."
        )
    if study.surplus:
        lines.append(f"{study.surplus} trials beyond the objects' shares were left out.")
    return lines


def pair_sentences(study: Study) -> list[str]:
    """Where L-infinity and L1 disagree, and which of them predicts correctly there."""
    p = study.paired[study.main]
    lines = [
        f"They predict different ends for {p.disagree.k} of {p.n} grasps "
        f"({_pct(p.disagree.value)}): L∞ alone is right about {p.only_first_right} of these, L1 "
        f"alone about {p.only_second_right}; McNemar's exact p = {p_value(p.p_value)}.",
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
    if p.areas is not None and p.areas.interval is not None and p.areas.p_value is not None:
        low, high = p.areas.interval
        better = "L∞" if p.areas.value > 0 else "L1"
        found = (
            f"{better} ranks better"
            if p.areas.p_value < 0.05
            else "the difference is not significant, which does not say that there is none"
        )
        lines.append(
            f"The areas under their ROC curves differ by {signed(p.areas.value)} "
            f"({signed(low)} to {signed(high)}; DeLong's p = {p_value(p.areas.p_value)}): {found}."
        )
    return lines


def load_sentences(study: Study) -> list[str]:
    """By how much each bound over- or underestimates the load held, and which is nearest."""
    metrics = list(study.load)
    known = {m: study.agreement[study.main, m, EVERY] for m in metrics}
    lines = []
    for metric, a in known.items():
        if a.ratio is None:
            continue
        low, high = a.ratio.median_interval
        verdict = "is not shown to be wrong"
        if low > 1.0 or high < 1.0:
            verdict = "overestimates" if low > 1.0 else "underestimates"
        lines.append(
            f"{name_of(metric)} {verdict} in the median of {a.ratio.n} trials that gave way: "
            f"q*/q_sim {a.ratio.median:.2f} ({low:.2f} to {high:.2f}), spread a factor "
            f"{a.ratio.spread:.2f} either way. In {a.both} of them both loads are above 0, in "
            f"{a.dropped} q_sim alone is 0, in {a.zero} q* alone, in {a.neither} both."
        )
    if study.nearest is not None and len(metrics) > 1:
        near = study.nearest
        text = (
            f"By its median, {name_of(near.metric)} is nearest to what the grasps hold, in "
            f"{_pct(near.share)} of resamples of the same trials"
        )
        if near.share < SURE and near.runner_up is not None:
            text += f" (else mostly {name_of(near.runner_up)}): too few to say so"
        lines.append(text + ".")
    any_one = known[metrics[0]]
    lines.append(
        f"Of {any_one.n} trials {any_one.capped} held the largest load tried and have no ratio."
    )
    return lines
