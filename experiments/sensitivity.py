"""How far the prediction depends on what it assumes: one assumption at a time, same grasps.

    python -m experiments.sensitivity RUN [--out FOLDER] [--seed 0]

The trials of RUN keep their outcomes; the metrics are computed again from the stored snapshots
with one assumption changed. Writes ``sensitivity.png`` and ``sensitivity.csv``.
"""

from __future__ import annotations

import csv
import functools
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import graspq as gq
from experiments.command_line import Parser
from experiments.stored_runs import read_runs
from sdh_sim.analysis.comparison import auc
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import RecordError
from sdh_sim.metrics import object_of, snapshot_of
from sdh_sim.objects import ObjectInfo
from sdh_sim.poses import rotation_of
from sdh_sim.records import NO_TRUTH
from sdh_sim.robot import built_in_hand, hand_kinematics
from sdh_sim.runs import RunFolder
from sdh_sim.sensing import GRAVITY, TactileSnapshot, pad_contacts
from sdh_sim.sensing.perceived_grasp import TASK_RADIUS, TASK_SAMPLES
from sdh_sim.user_references import ObjectFolder

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Assumption:
    """One assumption of the prediction and the values it is given.

    Attributes:
        name: for the picture.
        unit: of the values.
        values: tried in turn.
        default: the value the prediction uses.
    """

    name: str
    unit: str
    values: tuple[float, ...]
    default: float


FACTORS = (0.5, 0.7, 0.85, 0.95, 1.0, 1.05, 1.15, 1.3, 1.5, 2.0)
ASSUMPTIONS = {
    "friction": Assumption("friction", "× true", FACTORS, 1.0),
    "mass": Assumption("mass", "× true", FACTORS, 1.0),
    "torque": Assumption("torque limit", "× true", FACTORS, 1.0),
    "radius": Assumption("centre of mass radius", "mm", (0, 2, 4, 20 / 3, 10, 15, 20), 20 / 3),
    "edges": Assumption("edges of the friction cone", "", (3, 4, 6, 8, 12, 24, 48), 12),
    "noise": Assumption("noise of the readings", "%", (0, 5, 10, 20, 40, 80), 0),
    "dead": Assumption("dead taxels", "%", (0, 5, 10, 20, 40, 60), 0),
    "position": Assumption("tracked position, s.d.", "mm", (0, 1, 2, 4, 8, 16), 0),
    "rotation": Assumption("tracked rotation, s.d.", "deg", (0, 1, 2, 4, 8, 16), 0),
    "offset": Assumption("object frame off along its z", "mm", (-20, -10, -5, 0, 5, 10, 20), 0),
    "normals": Assumption("normals: pad's own 0, object's 1", "", (0, 0.25, 0.5, 0.75, 1), 1),
    "threshold": Assumption("threshold of contact", "kPa", (0, 1, 2, 5, 10, 20, 40), 0),
}


@dataclass(frozen=True)
class Setting:
    """One assumption at one value."""

    key: str
    value: float


Grasp = tuple[TactileSnapshot, ObjectInfo, tuple[float, ...]]


def changed(grasp: Grasp, setting: Setting, rng: np.random.Generator) -> Grasp:
    """What the prediction takes in, with the setting's change."""
    snapshot, obj, limits = grasp
    value = setting.value
    shift, turn = rng.standard_normal(3), rng.standard_normal(3)
    if setting.key == "friction":
        return snapshot, replace(obj, friction=obj.friction * value), limits
    if setting.key == "mass":
        return snapshot, replace(obj, mass_kg=obj.mass_kg * value), limits
    if setting.key == "torque":
        return snapshot, obj, (limits[0] * value, limits[1] * value)
    if setting.key == "offset":
        return snapshot, replace(obj, com_m=obj.com_m + 1e-3 * value * UP), limits
    if setting.key in ("position", "rotation"):
        angle = np.radians(value) * turn if setting.key == "rotation" else np.zeros(3)
        by = 1e-3 * value * shift if setting.key == "position" else np.zeros(3)
        return moved(snapshot, by, angle), obj, limits
    change = {
        "noise": lambda a: np.maximum(a * (1 + 0.01 * value * rng.standard_normal(a.shape)), 0.0),
        "dead": lambda a: np.where(rng.random(a.shape) < 0.01 * value, 0.0, a),
        "threshold": lambda a: np.where(a > value, a, 0.0),
    }.get(setting.key)
    if change is None:
        return grasp
    # In this order: it decides which random numbers an array gets.
    tactile = {kind: change(snapshot.tactile[kind]) for kind in ("proximal", "distal")}
    return replace(snapshot, tactile=tactile), obj, limits


def moved(snapshot: TactileSnapshot, by: np.ndarray, angle: np.ndarray) -> TactileSnapshot:
    """The snapshot with the object's pose shifted [m] and turned about its own axes [rad]."""
    import mujoco

    pose = snapshot.object_pose_hand.copy()
    pose[:3] += by
    mujoco.mju_quatIntegrate(pose[3:], angle, 1.0)
    return replace(snapshot, object_pose_hand=pose)


def scores(setting: Setting, grasps: Sequence[Grasp | None], pads: str, seed: int) -> np.ndarray:
    """q* under both bounds (n, 2); 0 without a snapshot or a contact."""
    hand = hand_kinematics()
    found = np.zeros((len(grasps), 2))
    for row, grasp in enumerate(grasps):
        if grasp is None:
            continue
        # The same draws for every value: curves differ by the assumption alone.
        rng = np.random.default_rng((seed, row))
        snapshot, obj, limits = changed(grasp, setting, rng)
        share = setting.value if setting.key == "normals" else 1.0
        contacts = pad_contacts(snapshot, obj, limits, pads, hand, share)
        if not contacts:
            continue
        edges = int(setting.value) if setting.key == "edges" else 12
        radius = 1e-3 * setting.value if setting.key == "radius" else TASK_RADIUS
        task = _task(snapshot, obj, radius)
        sets = [gq.contact_wrenches(p.contact, edges=edges, augment="hf") for p in contacts]
        for k, bound in enumerate(("linf", "l1")):
            found[row, k] = gq.task_scaling(sets, task, bound=bound).value
    return found


def _task(snapshot: TactileSnapshot, obj: ObjectInfo, radius: float) -> np.ndarray:
    down = np.array([0.0, 0.0, -GRAVITY])
    hand = rotation_of(snapshot.hand_pose_world[3:])
    local = rotation_of(snapshot.object_pose_hand[3:]).T @ hand.T @ down
    return gq.gravity_tasks(obj.mass_kg, np.zeros(3), local, radius, TASK_SAMPLES)


def read_grasps(run: Path) -> tuple[list[Grasp | None], np.ndarray]:
    """Grasps of a run and whether each held, without surplus and without trials without truth."""
    stored = read_runs([run])
    kept = [r for r in stored.rows if r["failure"] not in NO_TRUTH and not r.get("surplus")]
    return [_grasp(row, stored.folders) for row in kept], np.array(
        [bool(r["success"]) for r in kept]
    )


def _grasp(row: dict[str, Any], folders: Mapping[str, ObjectFolder]) -> Grasp | None:
    snapshot = snapshot_of(row)
    if snapshot is None:
        return None
    limits = built_in_hand().group_limits(row["torque_limit_nm"])
    return snapshot, object_of(row, folders), limits


def main(argv: list[str] | None = None) -> int:
    """Print the table, draw the curves."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder of sdh-sim lift")
    parser.add_argument("--out", type=Path, help="where to write [RUN/report]")
    parser.add_argument("--seed", type=int, default=0, help="of the noise [0]")
    parser.add_argument("--pads", choices=("all", "distal"), help="pads used [the run's]")
    args = parser.parse_args(argv)
    try:
        grasps, held = read_grasps(args.run)
        if held.all() or not held.any():
            raise RecordError(f"{args.run}: all outcomes are alike; nothing to rank")
        pads = args.pads or _pads_of(args.run)
        out = args.out or args.run / "report"
        out.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        print(f"sensitivity: {error}", file=sys.stderr)
        return 2
    settings = [Setting(key, v) for key, a in ASSUMPTIONS.items() for v in a.values]
    work: Callable[[Setting], np.ndarray] = functools.partial(
        scores, grasps=grasps, pads=pads, seed=args.seed
    )
    results = dict(zip(settings, run_all(work, settings, "assumptions"), strict=True))
    lines = [
        Line(s.key, s.value, *(summary(q[:, k], held) for k in (0, 1))) for s, q in results.items()
    ]
    with (out / "sensitivity.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("assumption", "value", "auc_linf", "accuracy_linf", "auc_l1",
                         "accuracy_l1"))  # fmt: skip
        writer.writerows((line.key, line.value, *line.linf, *line.l1) for line in lines)
    draw(lines, len(held), out / "sensitivity.png")
    Console(width=110).print(_table(lines))
    print(out / "sensitivity.png")
    return 0


def _pads_of(run: Path) -> str:
    return RunFolder(run).read_plan().settings.pads


def summary(q: np.ndarray, held: np.ndarray) -> tuple[float, float]:
    """Area under the ROC curve and accuracy at 1 of ``q``, where some held and some did not."""
    area = auc(q, held)
    assert area is not None  # main refuses outcomes that are all alike
    return area, float(np.mean((q > 1.0) == held))


class Line(NamedTuple):
    """Area under the curve and accuracy at 1 of both bounds, for one setting."""

    key: str
    value: float
    linf: tuple[float, float]
    l1: tuple[float, float]


def _table(lines: Sequence[Line]) -> Table:
    """The range over all values of each assumption."""
    table = Table(title="range over the values tried")
    for head in ("assumption", "AUC L∞", "AUC L1", "accuracy L∞ %", "accuracy L1 %"):
        table.add_column(head, justify="left" if head == "assumption" else "right")
    for key, assumption in ASSUMPTIONS.items():
        mine = np.array([
            (line.linf[0], line.l1[0], 100 * line.linf[1], 100 * line.l1[1])
            for line in lines
            if line.key == key
        ])  # fmt: skip
        low, high = mine.min(axis=0), mine.max(axis=0)
        cells = [f"{x:.2f} to {y:.2f}" for x, y in zip(low[:2], high[:2], strict=True)]
        cells += [f"{x:.0f} to {y:.0f}" for x, y in zip(low[2:], high[2:], strict=True)]
        table.add_row(assumption.name, *cells)
    return table


def _linf(line: Line) -> tuple[float, float]:
    return line.linf


def _l1(line: Line) -> tuple[float, float]:
    return line.l1


def draw(lines: Sequence[Line], count: int, path: Path) -> None:
    """One panel per assumption: AUC and accuracy under both bounds."""
    from matplotlib.figure import Figure

    rows = -(-len(ASSUMPTIONS) // 4)
    figure = Figure(figsize=(11, 2.75 * rows + 0.5), layout="constrained")
    axes = figure.subplots(rows, 4).ravel()
    styles = (("#0072b2", "L∞"), ("#d55e00", "L1"))
    floor = min(0.4, min(min(*line.linf, *line.l1) for line in lines) - 0.02)
    for ax, (key, assumption) in zip(axes, ASSUMPTIONS.items(), strict=False):
        mine = [line for line in lines if line.key == key]
        x = [line.value for line in mine]
        for pick, (colour, name) in zip((_linf, _l1), styles, strict=True):
            ax.plot(x, [pick(line)[0] for line in mine], "o-", ms=3, color=colour,
                    label=f"AUC {name}")  # fmt: skip
            ax.plot(x, [pick(line)[1] for line in mine], "s:", ms=3, color=colour, alpha=0.8,
                    label=f"accuracy at 1, {name}")  # fmt: skip
        ax.axvline(assumption.default, color="#bbbbbb", lw=1, zorder=0)
        ax.set_xlabel(f"{assumption.name} [{assumption.unit}]" if assumption.unit else
                      assumption.name)  # fmt: skip
        ax.set_ylim(floor, 1.01)
        ax.spines[["top", "right"]].set_visible(False)
    for ax in axes[len(ASSUMPTIONS) :]:
        ax.set_axis_off()
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", frameon=False, ncols=4,
        title=f"{count} grasps; grey: what is assumed",
    )  # fmt: skip
    figure.savefig(path, dpi=160)


if __name__ == "__main__":
    sys.exit(main())
