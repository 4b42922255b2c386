"""Pictures of the tests: what was done, drawn by MuJoCo's renderer, and the numbers as a chart."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from experiments.standard_tests.result_lines import TITLES, Line
from sdh_sim.cell import Scene
from sdh_sim.errors import RenderError
from sdh_sim.report.figure_style import save, style
from sdh_sim.viewing.render import renderer_of

SIZE = (420, 420)  # of a picture [pixels]
MOST = 4  # pictures beside each other
WIDE, HEAD, FOOT, LABELS = 7.2, 0.65, 0.7, 2.35  # of a figure and its margins [inch]
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#AA4499")


class Album:
    """Pictures taken along the way; without a headless OpenGL it stays empty.

    Attributes:
        pictures: by protocol, with their titles.
        lost: why there are none; empty where there are.
    """

    def __init__(self, wanted: bool = True) -> None:
        self.pictures: dict[str, list[tuple[str, np.ndarray]]] = {}
        self.lost = "" if wanted else "not asked for"

    def take(self, protocol: str, title: str, scene: Scene, data: mujoco.MjData) -> None:
        """Take a picture of the hand and the object as they are."""
        if self.lost:
            return
        model, (width, height) = scene.model, SIZE
        try:
            renderer = renderer_of(model, width, height)
        except RenderError as error:
            self.lost = str(error)
            return
        camera, options = mujoco.MjvCamera(), mujoco.MjvOption()
        options.geomgroup[:] = (1, 1, 1, 0, 0, 0)
        options.sitegroup[:] = 0
        middle = 0.5 * (data.xpos[scene.object_body] + data.xpos[scene.palm])
        camera.lookat[:] = middle
        camera.distance, camera.azimuth, camera.elevation = 0.42, 60.0, -12.0
        with renderer:
            objects = np.flatnonzero(scene.geom_group == 1)
            groups = model.geom_group[objects].copy()
            model.geom_group[objects] = 1  # a test object's shape is what is drawn of it
            renderer.update_scene(data, camera, options)
            picture = renderer.render().copy()
            model.geom_group[objects] = groups
        self.pictures.setdefault(protocol, []).append((title, picture))


def draw(
    protocol: str, lines: Sequence[Line], measured: Mapping[tuple[str, str], float],
    album: Album, stem: Path,
) -> Path:  # fmt: skip
    """A chart of the lines of a protocol, the pictures above it; returns the PNG."""
    import matplotlib.pyplot as plt

    shown: dict[str, tuple[str, np.ndarray]] = {}
    for title, picture in album.pictures.get(protocol, []):
        shown.setdefault(title.partition("\n")[2], (title, picture))
    pictures = list(shown.values())[:MOST]
    conditions = list(dict.fromkeys(line.condition for line in lines))
    hands = list(dict.fromkeys(line.specimen for line in lines))
    chart, above = 0.17 * len(conditions), (WIDE / MOST + 0.1) if pictures else 0.0
    tall = HEAD + above + chart + FOOT
    with style():
        figure = plt.figure(figsize=(WIDE, tall))
        for k, (title, picture) in enumerate(pictures):
            side = WIDE / MOST - 0.1
            axes = figure.add_axes(
                ((0.05 + k * WIDE / MOST) / WIDE, 1.0 - (HEAD + side) / tall, side / WIDE,
                 side / tall)
            )  # fmt: skip
            axes.imshow(picture)
            axes.set_title(title, fontsize=7.5)
            axes.set_axis_off()
        left = LABELS / WIDE
        axes = figure.add_axes((left, FOOT / tall, 0.98 - left, chart / tall))
        for k, hand in enumerate(hands):
            for line in (x for x in lines if x.specimen == hand):
                place = -conditions.index(line.condition) + 0.18 * (0.5 * (len(hands) - 1) - k)
                colour = COLOURS[k % len(COLOURS)]
                if not math.isnan(line.closed):
                    axes.plot(line.closed, place, "|", ms=9, mew=1.6, color=colour)
                if not math.isnan(line.simulated):
                    axes.plot(line.simulated, place, "o", ms=3.6, color=colour, alpha=0.8)
            axes.plot([], [], "o", ms=3.6, color=COLOURS[k % len(COLOURS)], label=hand)
        for (of, condition), value in measured.items():
            if of == protocol and condition in conditions:
                axes.plot(value, -conditions.index(condition), "D", ms=4.0, mfc="none", color="k")
        axes.plot([], [], "|", ms=9, mew=1.6, color="0.4", label="closed form")
        if any(of == protocol for of, _ in measured):
            axes.plot([], [], "D", ms=4.0, mfc="none", color="k", label="measured")
        axes.set_yticks([-k for k in range(len(conditions))], conditions, fontsize=7.5)
        axes.set_ylim(-len(conditions) + 0.4, 0.6)
        axes.set_xlim(left=0.0)
        axes.grid(axis="y")
        axes.set_xlabel("force [N]")
        figure.suptitle(TITLES[protocol], fontsize=10.0, y=1.0 - 0.08 / tall, va="top")
        figure.legend(fontsize=7.5, loc="lower center", ncols=5)
        _, png = save(figure, stem)
        plt.close(figure)
    return png
