"""The figures of a comparison, drawn from a ``Study`` and nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from sdh_sim.analysis.comparison import METRICS, THRESHOLD
from sdh_sim.analysis.curves import GRID
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.analysis.study import Study
from sdh_sim.report import figure_style as fs
from sdh_sim.report.dots import answering, draw_trials

Reference = Mapping[tuple[str, str], Mapping[str, float]]
"""Published numbers: by group and metric, of ``accuracy``, ``tpr``, ``tnr``, ``auc``."""

RATES = (("accuracy", 1.0), ("tpr", 0.6), ("tnr", 0.25))
_SMALL_DOT: dict[str, Any] = {"marker": "o", "markersize": 1.9, "markeredgewidth": 0.4}
_RATE_TEXTS = {"accuracy": "accuracy", "tpr": "true positive rate", "tnr": "true negative rate"}


def boxes(study: Study) -> Figure:
    """Figure 7: distribution of q* per object for grasps that held and that did not."""
    metrics = study.scalings
    columns = fs.columns_for(len(metrics))
    rows = -(-len(metrics) // columns)
    top = fs.ceiling([study.findings[study.main, m].scored.scores for m in metrics], 3.0)
    figure, axes = fs.panels(columns, 2.9 * rows, rows, sharey=True)
    objects = _objects(study)
    cases = answering(study.cases)
    for position, (ax, metric) in enumerate(zip(axes, metrics, strict=False)):
        colour = fs.colour_of(metric)
        for outcome, shift in ((True, -0.19), (False, 0.19)):
            samples = []
            for name in objects:
                scored = study.findings[name, metric].scored
                scores = scored.scores[scored.success == outcome]
                samples.append(np.clip(scores, 0.0, 0.985 * top))
            ax.boxplot(
                samples,
                positions=np.arange(len(objects)) + shift - (0.07 if cases else 0.0),
                widths=0.14 if cases else 0.3,
                patch_artist=True,
                manage_ticks=False,
                showfliers=not cases,
                flierprops={"marker": ".", "markersize": 3, "markeredgecolor": colour},
                medianprops={"color": "white" if outcome else colour, "linewidth": 1.4},
                boxprops={
                    "facecolor": fs.light(colour, 0.85 if outcome else 0.0),
                    "edgecolor": colour,
                },
                whiskerprops={"color": colour},
                capprops={"color": colour},
            )
            face = colour if outcome else "white"
            for x, (name, values) in enumerate(zip(objects, samples, strict=True)):
                own = [c for c in cases if c.object == name and c.success == outcome]
                if own:
                    aside = np.random.default_rng(0).uniform(0.05, 0.15, len(values))
                    draw_trials(ax, x + shift + aside, values, own, metric, color=colour,
                                markerfacecolor=face, **_SMALL_DOT)  # fmt: skip
        ax.axhline(THRESHOLD, color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
        ax.set_xticks(range(len(objects)), [fs.object_text(name) for name in objects])
        ax.tick_params(axis="x", length=0, labelsize=None if columns == 2 else 6.5)
        fs.letter(ax, position, fs.text_of(metric))
    axes[0].set_ylim(-0.1, top)  # shared
    for ax in axes[len(metrics) :]:
        ax.set_visible(False)
    for ax in axes[::columns]:
        ax.set_ylabel("task scaling $q^*$ [weights]")
    grey = "#444444"
    handles = [
        Patch(facecolor=fs.light(grey, 0.85), edgecolor=grey, label="grasps that held"),
        Patch(facecolor="white", edgecolor=grey, label="grasps that did not"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _objects(study: Study) -> list[str]:
    return [name for name in study.groups if name != "overall"] or [study.main]


def rates(study: Study, reference: Reference | None = None) -> Figure:
    """Figure 8: accuracy, true positive and true negative rate per object at threshold 1.

    Args:
        study: what to draw.
        reference: published numbers, drawn as diamonds where there are any.
    """
    metrics = [m for m in METRICS if m in study.metrics]
    figure, axes = fs.panels(len(metrics), 3.1, sharey=True)
    known = reference or {}
    for position, (ax, metric) in enumerate(zip(axes, metrics, strict=True)):
        colour = fs.colour_of(metric)
        for k, (name, share) in enumerate(RATES):
            for x, group in enumerate(study.groups):
                _bar(ax, x + 0.26 * (k - 1), _rate(study, group, metric, name), colour, share)
                value = known.get((group, metric), {}).get(name)
                if value is not None:
                    ax.plot(
                        x + 0.26 * (k - 1), value, marker="D", color="black", markersize=4.5,
                        markeredgecolor="white", markeredgewidth=0.8, zorder=4,
                    )  # fmt: skip
        ax.set_xticks(range(len(study.groups)), [fs.object_text(name) for name in study.groups])
        ax.tick_params(axis="x", length=0)
        ax.set_ylim(0, 1.03)
        ax.grid(axis="y")
        fs.letter(ax, position, f"{fs.text_of(metric)} $>$ {THRESHOLD:g} predicts success")
    axes[0].set_ylabel("share of the trials")
    handles: list[Patch | Line2D] = [
        Patch(facecolor=fs.light("#444444", share), edgecolor="#444444", label=_RATE_TEXTS[name])
        for name, share in RATES
    ]
    if known:
        handles.append(Line2D([], [], color="black", marker="D", markersize=4.5, linestyle="",
                              label="published"))  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _rate(study: Study, group: str, metric: str, name: str) -> Proportion:
    c = study.findings[group, metric].comparison
    return {
        "accuracy": c.accuracy,
        "tpr": c.true_positive_rate,
        "tnr": c.true_negative_rate,
    }[name]


def _bar(ax: Axes, x: float, rate: Proportion, colour: str, share: float) -> None:
    if rate.value is None or rate.interval is None:
        return
    ax.bar(x, rate.value, width=0.24, color=fs.light(colour, share), edgecolor=colour,
           linewidth=0.8)  # fmt: skip
    ends = np.abs(np.array(rate.interval) - rate.value)[:, None]
    ax.errorbar(x, rate.value, yerr=ends, color="#222222", linewidth=0.9, capsize=1.8)


def roc(study: Study, reference: Reference | None = None) -> Figure:
    """ROC curves of all trials with their bands, the threshold 1 marked."""
    figure, (ax,) = fs.panels(1, 4.1 + 0.19 * len(study.metrics), width=4.9)
    ax.plot([0, 1], [0, 1], color=fs.GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    for metric in study.metrics:
        finding = study.findings[study.main, metric]
        curve = finding.roc
        if curve is None:
            continue
        low, high = curve.area_interval
        text = f"{fs.text_of(metric)}   AUC {curve.area:.2f} ({low:.2f}–{high:.2f})"
        published = (reference or {}).get((study.main, metric), {}).get("auc")
        if published is not None:
            text += f", published {published:.2f}"
        ax.plot(curve.x, curve.y, color=fs.colour_of(metric), label=text)
        if metric in METRICS and curve.band is not None:
            ax.fill_between(GRID, *curve.band, color=fs.colour_of(metric), alpha=0.13,
                            linewidth=0)  # fmt: skip
        c = finding.comparison
        _dot(ax, metric, c.false_positive_rate.value, c.true_positive_rate.value)
    ax.set(xlim=(-0.01, 1.01), ylim=(-0.01, 1.01), aspect="equal")
    ax.set_xlabel("false positive rate")
    ax.set_ylabel("true positive rate")
    fs.legend_below(figure, ax, "dots: threshold 1")
    return figure


def precision_recall(study: Study) -> Figure:
    """Precision over recall of all trials with the bands, the threshold 1 marked."""
    figure, (ax,) = fs.panels(1, 4.1 + 0.19 * len(study.metrics), width=4.9)
    for metric in study.metrics:
        finding = study.findings[study.main, metric]
        curve = finding.precision_recall
        if curve is None:
            continue
        low, high = curve.area_interval
        text = f"{fs.text_of(metric)}   AP {curve.area:.2f} ({low:.2f}–{high:.2f})"
        ax.step(curve.x, curve.y, where="pre", color=fs.colour_of(metric), label=text)
        if metric in METRICS and curve.band is not None:
            ax.fill_between(GRID, *curve.band, color=fs.colour_of(metric), alpha=0.13,
                            linewidth=0)  # fmt: skip
        c = finding.comparison
        _dot(ax, metric, c.true_positive_rate.value, Proportion(c.tp, c.tp + c.fp).value)
    base = study.findings[study.main, study.metrics[0]].comparison.success.value
    if base is not None:
        ax.axhline(base, color=fs.GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    ax.set(xlim=(-0.01, 1.01), ylim=(0, 1.02))
    ax.set_xlabel("recall (true positive rate)")
    ax.set_ylabel("precision")
    fs.legend_below(figure, ax, "dots: threshold 1")
    return figure


def _dot(ax: Axes, metric: str, x: float | None, y: float | None) -> None:
    """A dot for the threshold 1, if the metric is a task scaling and both rates are defined."""
    if metric.startswith("q_") and x is not None and y is not None:
        ax.plot(x, y, marker="o", color=fs.colour_of(metric), markeredgecolor="white", markersize=7)
