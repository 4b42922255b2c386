"""How near grasps are to the other label: lifts with a little more or less friction or damping.

    python -m experiments.two_engines.label_margins RUN... [--others 60] [--seed 0]

Needs the tables of ``python -m experiments.two_engines RUN...``. Every grasp that the engines label
differently, and as many as wished that they label alike, is lifted again in both, straight up, with
friction of all surfaces 3 and 6 % lower and higher, and with half and twice the damping of the
pads' contacts. A label that such a change turns is that of a grasp on the edge: no engine knows
friction to 3 %, nor does anybody of a real object. Rows go to ``RUN/two_margins.csv``.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least, fail
from experiments.stored_runs import read_runs
from experiments.two_engines.alignment import ALIGNED, FULL
from experiments.two_engines.drake import need_drake
from experiments.two_engines.start import Start, start_of
from experiments.two_engines.straight import straight_lift
from experiments.two_engines.table import LABELS, RowTable
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cell import Scene
from sdh_sim.cli.worker_pool import run_each
from sdh_sim.errors import Diverged, RecordError, RunError, SettingsError
from sdh_sim.runs import Job
from sdh_sim.trial import Motion, classify

ENGINES = ("MuJoCo", "Drake")
AS_IT_IS = "none"


class Change(NamedTuple):
    """Factors on the contacts of a model.

    Attributes:
        friction: on the coefficients of all surfaces.
        damping: on the damping of the taxels' contacts.
    """

    friction: float = 1.0
    damping: float = 1.0


CHANGES = {
    AS_IT_IS: Change(),
    "friction -3 %": Change(friction=0.97),
    "friction +3 %": Change(friction=1.03),
    "friction -6 %": Change(friction=0.94),
    "friction +6 %": Change(friction=1.06),
    "damping / 2": Change(damping=0.5),
    "damping x 2": Change(damping=2.0),
}
GROUPS = {
    "friction by 3 %": ("friction -3 %", "friction +3 %"),
    "friction by 6 %": ("friction -3 %", "friction +3 %", "friction -6 %", "friction +6 %"),
    "damping by 2": ("damping / 2", "damping x 2"),
    "any of these": tuple(name for name in CHANGES if name != AS_IT_IS),
}
MARGINS = RowTable(
    "two_margins.csv",
    {
        "trial": int, "object": str, "engine": str, "change": str, "success": bool,
        "displacement_mm": float, "rotation_deg": float,
    },
    ("trial", "engine", "change"),
)  # fmt: skip


def changed(scene: Scene, change: Change) -> Scene:
    """The scene with a model of its own, of which the contacts are changed."""
    model = copy.copy(scene.model)
    model.geom_friction[:, 0] *= change.friction
    model.geom_solref[scene.taxel >= 0, 1] *= change.damping
    return replace(scene, model=model)


def lifts(task: tuple[Job, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Lift the grasp of a trial, given with its row, in both engines with every change.

    Raises:
        RunError: as ``start_of``.
    """
    job, row = task
    start = start_of(job, row)
    rows = []
    for name, change in CHANGES.items():
        for engine in ENGINES:
            motion = _lifted(start, change, engine)
            rows.append(
                {
                    "trial": job.trial, "object": job.settings.object, "engine": engine,
                    "change": name, "success": classify(motion) == "none",
                    "displacement_mm": motion.displacement_mm, "rotation_deg": motion.rotation_deg,
                }
            )  # fmt: skip
    return rows


def _lifted(start: Start, change: Change, engine: str) -> Motion:
    from experiments.two_engines.outcomes import lift
    from experiments.two_engines.trials import set_off

    try:
        if engine == "MuJoCo":
            return straight_lift(start, lambda scene: changed(scene, change))
        other = replace(start, scene=changed(start.scene, change))
        return lift(set_off(other, ALIGNED), start.lift_time)
    except Diverged:
        return Motion(math.nan, math.nan, True)


class Turned(NamedTuple):
    """Which changes turn the label of a grasp, or leave it, engine by engine.

    Attributes:
        object, trial: of the run.
        labels: by engine and change, True where the object is held.
    """

    object: str
    trial: int
    labels: Mapping[tuple[str, str], bool]

    @property
    def alike(self) -> bool:
        """Whether both engines say the same of the grasp as it is, lifted straight up."""
        return self.labels["MuJoCo", AS_IT_IS] == self.labels["Drake", AS_IT_IS]

    def turned(self, engine: str, names: Iterable[str]) -> list[str]:
        """Those of the changes that turn the label in an engine."""
        usual = self.labels[engine, AS_IT_IS]
        return [name for name in names if self.labels[engine, name] != usual]


def grasps_of(rows: Iterable[Mapping[str, Any]]) -> list[Turned]:
    """Rows of ``MARGINS`` of one run, grasp by grasp; incomplete ones are left out."""
    found: dict[tuple[str, int], dict[tuple[str, str], bool]] = {}
    for row in rows:
        labels = found.setdefault((row["object"], row["trial"]), {})
        labels[row["engine"], row["change"]] = row["success"]
    complete = len(CHANGES) * len(ENGINES)
    return [Turned(*key, labels) for key, labels in found.items() if len(labels) == complete]


def report(grasps: Sequence[Turned], console: Console) -> None:
    """Print what turns the labels on which the engines differ, and how often others turn."""
    table = Table(title="Different labels, lifted straight up, and what turns them")
    for head in ("object", "trial", "held in", *(f"turned in {engine} by" for engine in ENGINES)):
        table.add_column(head)
    for grasp in grasps:
        if not grasp.alike:
            holding = "MuJoCo" if grasp.labels["MuJoCo", AS_IT_IS] else "Drake"
            by = (", ".join(grasp.turned(e, GROUPS["any of these"])) or "-" for e in ENGINES)
            table.add_row(grasp.object, str(grasp.trial), holding, *by)
    console.print(table)
    shares = Table(title="Grasps with a label that one engine turns")
    shares.add_column("by")
    shares.add_column("where they differ %", justify="right")
    for engine in (*ENGINES, "either"):
        shares.add_column(f"where they agree: {engine} %", justify="right")
    for title, names in GROUPS.items():
        apart = [any(g.turned(e, names) for e in ENGINES) for g in grasps if not g.alike]
        cells = [_share(apart)]
        for engines in (*((e,) for e in ENGINES), ENGINES):
            cells.append(
                _share([any(g.turned(e, names) for e in engines) for g in grasps if g.alike])
            )
        shares.add_row(title, *cells)
    console.print(shares)


def _share(turned: Sequence[bool]) -> str:
    found = Proportion(sum(turned), len(turned))
    return f"{found.k} of {found.n}: {found.percent}"


def _missing(
    run: Path, others: int, rng: np.random.Generator
) -> list[tuple[Job, Mapping[str, Any]]]:
    """Grasps of a run that are to be lifted again, with their rows."""
    stored = read_runs([run])
    drake = {r["trial"]: r["success"] for r in LABELS.read(run) if r["alignment"] == FULL}
    rows = [row for row in stored.rows if row["trial"] in drake]
    differ = [row for row in rows if row["success"] != drake[row["trial"]]]
    alike = [row for row in rows if row["success"] == drake[row["trial"]]]
    chosen = rng.permutation(len(alike))[:others]
    there = {grasp.trial for grasp in grasps_of(MARGINS.read(run))}
    wanted = [*differ, *(alike[k] for k in sorted(chosen))]
    return [(stored.plan.job(r["trial"]), r) for r in wanted if r["trial"] not in there]


def main(argv: list[str] | None = None) -> None:
    """Compute what is missing, and print what turns labels."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, nargs="+", help="run folders that have been compared")
    parser.add_argument(
        "--others", type=int, default=60, help="grasps on which the engines agree, of all runs [60]"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the choice of these [0]")
    parser.add_argument("--workers", type=int, default=0, help="processes (default: one per core)")
    args = parser.parse_args(argv)
    at_least(parser, args, others=0, seed=0, workers=0)
    need_drake()
    grasps, rng = [], np.random.default_rng(args.seed)
    try:
        for k, run in enumerate(args.run):
            others = args.others // len(args.run) + (k < args.others % len(args.run))
            jobs = _missing(run, others, rng)
            for rows in run_each(lifts, jobs, str(run), args.workers):
                MARGINS.append(run, rows)
            grasps += grasps_of(MARGINS.read(run))
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    report(grasps, Console(width=140))


if __name__ == "__main__":
    main()
