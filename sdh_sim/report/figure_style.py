"""Style of the figures: one palette, one size of type, and the same bytes for the same figure.

Colours are Okabe and Ito's, which stay apart for colour-blind readers. A metric keeps its colour in
every figure; the fill shows the outcome: full for grasps that held, hollow for the others.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib import colors
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sdh_sim.atomic_files import write_atomic
from sdh_sim.records import METRIC

COLOURS = {
    "q_linf": "#0072B2",
    "q_l1": "#D55E00",
    "q_capability": "#009E73",
    "q_held": "#AA4499",
    "q_whole_hand": "#332288",
    "q_settled": "#CC3311",
    "epsilon_linf": "#56B4E9",
    "epsilon_l1": "#E69F00",
    "volume_linf": "#555555",
    "volume_l1": "#999999",
}
TEXTS = {
    "q_linf": r"$q^*_{L_\infty}$",
    "q_l1": r"$q^*_{L_1}$",
    "q_capability": r"$q^*_{\mathrm{capability}}$",
    "q_held": r"$q^*_{\mathrm{held}}$",
    "q_whole_hand": r"$q^*_{\mathrm{whole\ hand}}$",
    "q_settled": r"$q_{\mathrm{settling}}$",
    "epsilon_linf": r"$\varepsilon_{L_\infty}$",
    "epsilon_l1": r"$\varepsilon_{L_1}$",
    "volume_linf": r"$V_{L_\infty}$",
    "volume_l1": r"$V_{L_1}$",
}
# Of users' metrics: Tol's colours, which differ from those above.
_OTHERS = ("#882255", "#117733", "#44AA99", "#999933", "#661100")
GREY = "#666666"
WIDTH = 7.2  # [inch] of a figure over the whole text

_STYLE = {
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.5,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.grid": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    # Letters are then as wide at every resolution: what is laid out once fits both files.
    "text.hinting": "none",
    "svg.fonttype": "path",  # the page looks the same without our fonts
    "svg.hashsalt": "sdh-sim",
    "axes.unicode_minus": True,
}


def colour_of(metric: str) -> str:
    """Colour of a metric, a user's included."""
    return COLOURS.get(metric) or _OTHERS[zlib.crc32(metric.encode()) % len(_OTHERS)]


def text_of(metric: str) -> str:
    """What a metric is called in a figure."""
    return TEXTS.get(metric) or metric.removeprefix(METRIC).replace("_", " ")


def style() -> AbstractContextManager[None]:
    """The figures' settings, for a ``with`` around both drawing and saving."""
    return matplotlib.rc_context(_STYLE)  # type: ignore[arg-type]


def panels(
    columns: int, height: float, rows: int = 1, *, width: float = WIDTH,
    sharex: bool = False, sharey: bool = False,
) -> tuple[Figure, list[Axes]]:  # fmt: skip
    """An empty figure, sizes in inches, and its axes row by row."""
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=sharex, sharey=sharey)
    return figure, list(axes.flat)


def columns_for(count: int) -> int:
    """How many of ``count`` panels stand side by side."""
    return 2 if count <= 4 else 3


def ceiling(values: Iterable[np.ndarray], least: float) -> float:
    """Upper limit of an axis: a little above the 99.5 % quantile, and at least ``least``.

    So a few huge values do not compress the others; they are drawn at the limit, as in the paper.
    """
    every = np.concatenate([np.asarray(v, dtype=float) for v in values])
    every = every[np.isfinite(every)]
    return max(least, 1.15 * float(np.percentile(every, 99.5)) if len(every) else least)


def letter(axes: Axes, position: int, text: str) -> None:
    """Title of a panel: (a), (b), … and what it shows."""
    axes.set_title(f"({'abcdefgh'[position]}) {text}", loc="left")


def legend(axes: Axes, **options: Any) -> None:
    """The axes' legend, none where nothing has a label (too few trials to draw a curve)."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(alignment="left", title_fontsize=8.5, **options)


def legend_below(figure: Figure, axes: Axes, title: str) -> None:
    """The axes' legend below them, where it hides no curve; none where nothing has a label."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", title=title, title_fontsize=8.5)


def light(colour: str, share: float) -> tuple[float, float, float]:
    """The colour mixed with white: share 1 is the colour itself, 0 white."""
    red, green, blue = colors.to_rgb(colour)
    return (1 - share * (1 - red), 1 - share * (1 - green), 1 - share * (1 - blue))


def object_text(name: str) -> str:
    """An object's name below an axis, one word a line."""
    return name.replace("_", "\n").capitalize()


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write ``stem``.svg and ``stem``.png, the same bytes for the same figure; raises OSError."""
    paths = stem.with_suffix(".svg"), stem.with_suffix(".png")
    dateless: dict[str, dict[str, str | None]] = {
        ".svg": {"Date": None, "Creator": None},
        ".png": {"Software": None},
    }
    figure.draw_without_rendering()
    figure.set_layout_engine(None)  # laid out already, once for both files; "none" draws twice
    for path in paths:
        buffer = io.BytesIO()
        figure.savefig(buffer, format=path.suffix[1:], dpi=200, metadata=dateless[path.suffix])
        write_atomic(path, buffer.getvalue())
    return paths
