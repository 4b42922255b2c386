"""Figures of calibrated thresholds, and of q* against q_sim of the load test."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from sdh_sim.analysis.comparison import METRICS
from sdh_sim.analysis.load_agreement import load_ratios
from sdh_sim.analysis.study import EVERY, Study
from sdh_sim.report import figure_style as fs
from sdh_sim.report.dots import answering, draw_trials, select

_DOT: dict[str, Any] = {
    "linestyle": "", "marker": "o", "markersize": 3.6, "markeredgewidth": 0.8
}  # fmt: skip
# Ratios q*/q_sim beyond these are drawn there.
RATIO_EDGES = (0.1, 10.0)
_ARROW: dict[str, Any] = {"linestyle": "", "marker": ">", "markersize": 4.5}


def calibration(study: Study) -> Figure:
    """Threshold, true and false positive rate over the desired false positive rate."""
    figure, axes = fs.panels(3, 2.9)
    metrics = [m for m in METRICS if m in study.metrics]
    for metric in metrics:
        c = study.findings[study.main, metric].calibration
        if c is None:
            continue
        colour = fs.colour_of(metric)
        finite = np.isfinite(c.threshold)
        band = finite & np.isfinite(c.threshold_low)
        axes[0].step(c.targets[finite], c.threshold[finite], where="post", color=colour,
                     label=fs.text_of(metric))  # fmt: skip
        axes[0].fill_between(c.targets[band], c.threshold_low[band], c.threshold_high[band],
                             step="post", color=colour, alpha=0.15, linewidth=0)  # fmt: skip
        axes[1].step(c.targets, c.tpr, where="post", color=colour)
        axes[1].fill_between(c.targets, c.tpr_low, c.tpr_high, step="post", color=colour,
                             alpha=0.15, linewidth=0)  # fmt: skip
        got = np.array([rate.value for rate in c.achieved], dtype=float)
        axes[2].plot(c.targets, got, color=colour)
    axes[0].axhline(1.0, color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
    axes[0].set_ylim(bottom=0)
    axes[1].set_ylim(0, 1)
    axes[2].plot([0, 0.5], [0, 0.5], color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
    axes[2].set_ylim(0, max(0.6, 1.03 * axes[2].dataLim.y1))
    titles = ("threshold needed", "successes still predicted", "false positives held out")
    for k, text in enumerate(titles):
        axes[k].set_xlabel("desired false positive rate")
        axes[k].set_xlim(0, 0.5)
        axes[k].xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        fs.letter(axes[k], k, text)
        if k:
            axes[k].yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes[0].set_ylabel("threshold on $q^*$ [weights]")
    fs.legend(axes[0], loc="upper right")
    return figure


def load_scatter(study: Study) -> Figure:
    """q* against q_sim, one dot a trial; ρ is the rank correlation."""
    metrics = [m for m in study.scalings if m in study.load]
    columns = fs.columns_for(len(metrics))
    rows = -(-len(metrics) // columns)
    figure, axes = fs.panels(columns, (1.2 + 5.4 / columns) * rows, rows, sharex=True, sharey=True)
    largest = max(np.max(values.q_sim, initial=1.0) for values in study.load.values())
    limit = fs.ceiling([study.load[metric].q for metric in metrics], 1.15 * float(largest))
    cases = [case for case in answering(study.cases) if case.q_sim is not None]
    for position, (ax, metric) in enumerate(zip(axes, metrics, strict=False)):
        q, q_sim, capped, unsensed = study.load[metric]
        q = np.clip(q, 0.0, 0.97 * limit)  # what lies beyond is drawn at the edge
        ax.plot([0, limit], [0, limit], color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)))
        colour = fs.colour_of(metric)
        for part, face in ((~unsensed, colour), (unsensed, "white")):
            shown = part & ~capped
            draw_trials(ax, q_sim[shown], q[shown], select(cases, shown), metric, alpha=0.8,
                        markerfacecolor=face, markeredgecolor=colour, **_DOT)  # fmt: skip
        draw_trials(ax, q_sim[capped], q[capped], select(cases, capped), metric, color=colour,
                    **_ARROW)  # fmt: skip
        # Linear below one weight, so that zeros have a place; logarithmic above.
        ax.set_xscale("symlog", linthresh=1.0, linscale=0.9)
        ax.set_yscale("symlog", linthresh=1.0, linscale=0.9)
        ax.set(xlim=(-0.06, limit), ylim=(-0.06, limit), aspect="equal")
        ticks = [t for t in (0, 0.5, 1, 2, 5, 10, 20) if t <= limit]
        ax.set_xticks(ticks, [f"{t:g}" for t in ticks])
        ax.set_yticks(ticks, [f"{t:g}" for t in ticks])
        ax.minorticks_off()
        a = study.agreement[study.main, metric, EVERY]
        text = fs.text_of(metric)
        if a.spearman is not None:
            text += f", ρ {a.spearman:.2f}"
        fs.letter(ax, position, text)
        ax.set_ylabel("$q^*$ [weights]" if position % columns == 0 else "")
    for ax in axes[max(0, len(metrics) - columns) : len(metrics)]:
        ax.set_xlabel(r"$q_{\mathrm{sim}}$ [weights]")
        ax.tick_params(labelbottom=True)  # sharex hides them above an empty panel
    for ax in axes[len(metrics) :]:
        ax.set_visible(False)
    grey = "#444444"
    handles = [
        Line2D([], [], markerfacecolor=grey, markeredgecolor=grey,
               label="the pads feel all that bears load", **_DOT),
        Line2D([], [], markerfacecolor="white", markeredgecolor=grey,
               label="something else bears load too", **_DOT),
    ]  # fmt: skip
    if any(values.capped.any() for values in study.load.values()):
        handles.append(Line2D([], [], color=grey, label="largest load held", **_ARROW))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def load_ratio(study: Study) -> Figure:
    """Distribution of q*/q_sim for each bound; 0 and infinity stand at the edges."""
    metrics = [m for m in study.scalings if m in study.load]
    figure, (ax,) = fs.panels(1, 0.6 + 0.55 * len(metrics), width=5.6)
    tested = [case for case in answering(study.cases) if case.q_sim is not None]
    samples, cases = [], []
    for metric in metrics:
        q, q_sim, capped, _ = study.load[metric]
        cases.append(select(tested, ~capped))
        samples.append(np.clip(load_ratios(q, q_sim, capped), *RATIO_EDGES))
    for position, (metric, ratio) in enumerate(zip(metrics, samples, strict=True)):
        colour = fs.colour_of(metric)
        spread = np.random.default_rng(0).uniform(-0.16, 0.16, len(ratio))
        draw_trials(ax, ratio, position + spread, cases[position], metric, marker="o",
                    markersize=2.6, color=colour, alpha=0.35, markeredgewidth=0)  # fmt: skip
        ax.boxplot([ratio], positions=[position], widths=0.5, orientation="horizontal",
                   showfliers=False, manage_ticks=False,
                   medianprops={"color": colour, "linewidth": 2.2},
                   boxprops={"color": colour}, whiskerprops={"color": colour},
                   capprops={"color": colour})  # fmt: skip
    ax.axvline(1.0, color=fs.GREY, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
    ax.set_xscale("log")
    low, high = RATIO_EDGES
    ax.set_xlim(low / 1.1, high * 1.1)
    ax.set_xticks(
        [low, 0.2, 0.5, 1, 2, 5, high], [f"≤ {low:g}", "0.2", "0.5", "1", "2", "5", f"≥ {high:g}"]
    )
    ax.minorticks_off()
    ax.set_yticks(range(len(metrics)), [fs.text_of(m) for m in metrics])
    ax.invert_yaxis()
    ax.set_xlabel(r"$q^* \,/\, q_{\mathrm{sim}}$")
    return figure
