"""Table I and figure 6 of Krug et al. (2017): random grasps under both contact force bounds.

Section IV-A on this project's four objects: three random mesh vertices, unit normal forces, hard
fingers with 12 edges, a random task wrench of length 0.1 to 1 about the mesh origin, kept when
q* under independent bounds is at least 1. The published grasps are evaluated too where their
data file is given.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import graspq as gq
from experiments.command_line import Parser, at_least, fail

# Friction coefficients of the paper's figure 5.
OBJECTS = {"box": 0.63, "oval_bottle": 0.63, "spray_bottle": 0.68, "cylindrical_bottle": 0.60}
MODELS = Path(__file__).resolve().parents[1] / "models" / "objects"
PAPER = {
    "linf": ("1.64 ± 0.8", "10.59 ± 10.0", "13.97 ± 9.5", "0.33", "9.04"),
    "l1": ("0.72 ± 0.4", "0.11 ± 0.1", "6.04 ± 4.0", "0.38", "0.06"),
}
NAMES = {"linf": "L∞", "l1": "L1"}
CHUNK = 500


@dataclass(frozen=True)
class Row:
    """Metrics of many grasps under one bound; the times are per grasp [s]."""

    q: np.ndarray
    epsilon: np.ndarray
    volume: np.ndarray
    q_time: float
    gws_time: float


def load_mesh(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 3) [m] and inward unit normals (v, 3) of an object's outer mesh."""
    import trimesh

    path = folder / "assets" / f"{folder.name}.obj"
    if not path.is_file():
        path = folder / "assets" / "visual_body.obj"
    mesh = trimesh.load_mesh(path)
    return np.array(mesh.vertices, float), -np.array(mesh.vertex_normals, float)


def random_grasps(
    points: np.ndarray,
    normals: np.ndarray,
    friction: float,
    count: int,
    rng: np.random.Generator,
    advance: Any,
) -> tuple[list[list[np.ndarray]], list[np.ndarray]]:
    """Grasps and task wrenches that independent bounds can exert."""
    cones = [
        gq.contact_wrenches(gq.Contact(p, n, friction))
        for p, n in zip(points, normals, strict=True)
    ]
    grasps: list[list[np.ndarray]] = []
    wanted: list[np.ndarray] = []
    tried = 0
    while len(grasps) < count:
        tried += CHUNK
        if tried > 2000 * count:
            fail(f"only {len(grasps)} of {count} grasps found among {tried}; is the mesh closed?")
        ids = [rng.choice(len(points), 3, replace=False) for _ in range(CHUNK)]
        task = rng.normal(size=(CHUNK, 6))
        task *= (rng.uniform(0.1, 1.0, CHUNK) / np.linalg.norm(task, axis=1))[:, None]
        drawn = [[cones[i] for i in trio] for trio in ids]
        tasks = [t[:, None].copy() for t in task]
        for i in np.flatnonzero(gq.task_scaling_batch(drawn, tasks).value >= 1.0):
            if len(grasps) < count:
                grasps.append(drawn[i])
                wanted.append(tasks[i])
                advance()
    return grasps, wanted


def evaluate(grasps: list[list[np.ndarray]], tasks: list[np.ndarray], bound: str) -> Row:
    """All metrics of all grasps, one call at a time, as the paper timed them."""
    gq.task_scaling(grasps[0], tasks[0], bound)
    gq.epsilon(grasps[0], bound)
    gq.volume(grasps[0], bound)
    begin = time.perf_counter()
    q = np.array([gq.task_scaling(g, t, bound).value for g, t in zip(grasps, tasks, strict=True)])
    middle = time.perf_counter()
    epsilon = np.array([gq.epsilon(g, bound) for g in grasps])
    volume = np.array([gq.volume(g, bound) for g in grasps])
    end = time.perf_counter()
    return Row(q, epsilon, volume, (middle - begin) / len(q), (end - middle) / len(q))


def print_table(title: str, rows: dict[str, Row], console: Any) -> None:
    """Table I beside the paper's, and the shares that the text quotes."""
    from rich.table import Table

    table = Table(title=title)
    for head in ("bound", "q*", "V [1e-3]", "ε [1e-3]", "t q* [ms]", "t ε and V [s]"):
        table.add_column(head, justify="right" if head != "bound" else "left")
    closed = rows["linf"].epsilon > 0
    for bound, row in rows.items():

        def both(values: np.ndarray, scale: float = 1.0) -> str:
            if not len(values):
                return "none"
            return f"{scale * values.mean():.2f} ± {scale * values.std():.2f}"

        table.add_row(
            NAMES[bound],
            both(row.q),
            both(row.volume, 1e3),
            both(row.epsilon[closed], 1e3),
            f"{1e3 * row.q_time:.3f}",
            f"{row.gws_time:.4f}",
        )
        table.add_row(f"{NAMES[bound]} paper", *PAPER[bound], style="dim")
    console.print(table)
    console.print(
        f"force closure {100 * closed.mean():.1f} % (paper 41.9 %), misjudged by L1"
        f" (q* < 1) {100 * (rows['l1'].q < 1).mean():.1f} % (paper 86.7 %)"
    )


def draw(rows: dict[str, dict[str, Row]], path: Path) -> None:
    """Figure 6: q* per object under both bounds, clipped at 3."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    for k, (bound, colour) in enumerate((("linf", "#1f6f8b"), ("l1", "#d1603d"))):
        boxes = axes.boxplot(
            [np.minimum(r[bound].q, 3.0) for r in rows.values()],
            widths=0.32,
            patch_artist=True,
            positions=np.arange(len(rows)) + 0.36 * k - 0.18,
            medianprops={"color": "black"},
            flierprops={"markersize": 2},
        )
        for box in boxes["boxes"]:
            box.set_facecolor(colour)
        boxes["boxes"][0].set_label(f"$q^*$ {NAMES[bound]}")
    axes.axhline(1.0, color="grey", linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(rows)), [name.replace("_", " ") for name in rows])
    axes.set_ylabel("$q^*$ (clipped at 3)")
    axes.legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=160)
    plt.close(figure)


def compare_published(path: Path, console: Any) -> None:
    """Print the largest deviation from the published values."""
    data = np.load(path)
    for name in sorted({key.split("/")[0] for key in data.files}):
        points, normals = data[f"{name}/points_m"], data[f"{name}/inward_vertex_normals"]
        friction = float(data[f"{name}/friction"])
        grasps = [
            [gq.contact_wrenches(gq.Contact(points[i], normals[i], friction)) for i in ids]
            for ids in data[f"{name}/grasp_vertex_ids"]
        ]
        tasks = [t[:, None].copy() for t in data[f"{name}/task_wrench"]]
        for bound in NAMES:
            row = evaluate(grasps, tasks, bound)
            closed = data[f"{name}/force_closure_{bound}"]
            q, v = data[f"{name}/q_{bound}"], data[f"{name}/volume_{bound}"]
            far = np.abs(row.epsilon - data[f"{name}/epsilon_{bound}"])[closed].max()
            console.print(
                f"published {name} {NAMES[bound]}: {len(q)} grasps, largest deviation q*"
                f" {np.abs(row.q / q - 1).max():.1e} relative, ε {far:.1e}, V"
                f" {np.abs(row.volume / v - 1).max():.1e} relative,"
                f" {int(((row.epsilon > 0) != closed).sum())} force closure flags differ"
            )


def main(arguments: list[str] | None = None) -> None:
    """Run the study from the command line."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=250, help="grasps per object")
    parser.add_argument("--objects", nargs="+", default=list(OBJECTS), help="which objects")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("runs/table1"), help="folder of figure 6")
    parser.add_argument(
        "--reference",
        type=Path,
        help="published grasps (.npz); default: GRASPQ_REFERENCE_DATA where it is set",
    )
    options = parser.parse_args(arguments)
    at_least(parser, options, grasps=1, seed=0)
    for name in options.objects:
        if name not in OBJECTS:
            fail(f"--objects: unknown {name!r}; there are {', '.join(OBJECTS)}")
        if not (MODELS / name).is_dir():
            fail(f"--objects: {name!r} has no meshes in models/objects; run from a checkout")
    reference = options.reference or os.environ.get("GRASPQ_REFERENCE_DATA")
    if reference and not Path(reference).is_file():
        fail(f"--reference: no file at {reference}")
    if options.out.exists() and not options.out.is_dir():
        fail(f"--out: {options.out} is a file; give a folder")
    run(options, Path(reference) if reference else None)


def run(options: argparse.Namespace, reference: Path | None) -> None:
    """Sample, evaluate, print and draw."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console()
    rng = np.random.default_rng(options.seed)
    rows: dict[str, dict[str, Row]] = {}
    with Progress(console=console, transient=True) as progress:
        bar = progress.add_task("grasps", total=options.grasps * len(options.objects))
        for name in options.objects:
            points, normals = load_mesh(MODELS / name)
            progress.update(bar, description=name)
            grasps, tasks = random_grasps(
                points, normals, OBJECTS[name], options.grasps, rng, lambda: progress.advance(bar)
            )
            rows[name] = {b: evaluate(grasps, tasks, b) for b in NAMES}
    for name, row in rows.items():
        print_table(f"{name}: {options.grasps} random grasps", row, console)
    if len(rows) > 1:
        print_table(
            f"all {len(rows)} objects",
            {b: merge([r[b] for r in rows.values()]) for b in NAMES},
            console,
        )
    picture = options.out / "figure6.png"
    draw(rows, picture)
    console.print(f"figure 6: {picture}")
    if reference:
        compare_published(reference, console)


def merge(rows: list[Row]) -> Row:
    """All objects' grasps together."""
    return Row(
        np.concatenate([r.q for r in rows]),
        np.concatenate([r.epsilon for r in rows]),
        np.concatenate([r.volume for r in rows]),
        float(np.mean([r.q_time for r in rows])),
        float(np.mean([r.gws_time for r in rows])),
    )


if __name__ == "__main__":
    main()
