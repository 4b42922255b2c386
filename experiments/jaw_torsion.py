"""Where L1 promises the parallel jaw too much: weights beside the line that joins its pads.

    python -m experiments.jaw_torsion --draws 20 --seed 12

Nothing but friction keeps the object from turning about the line that joins the pads, the pinch
line. Each random grasp that the pads alone make is loaded by the rule of q_sim, once as it is, and
once with the weight at each of several distances beside that line, halfway between the pads. What
it bears stands beside q* by L1 with the centre of mass known, and beside what an ellipse of shear
and equation 7's torsion gives in closed form, with the same force on the pads. Distances are in
arms: equation 7 is friction times force times the mean arm of a pad's taxels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table

import graspq as gq
from experiments.command_line import Parser, at_least, fail
from experiments.devices import PADS_ALONE
from sdh_sim.analysis.load_agreement import load_ratios
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import Diverged, SettingsError
from sdh_sim.metrics import task_scaling
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.runs.plan import trial_seed
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.sensing.perceived_grasp import gravity_task
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, load_test

DISTANCES = (0.0, 0.5, 1.0, 2.0, 4.0)  # of the weight from the pinch line [arms]
BINS = {
    "below 0.5": (0.0, 0.5),
    "0.5 to 1": (0.5, 1.0),
    "above 1": (1.0, math.inf),
    "all": (0.0, math.inf),
}
LOADS = ("L1", "ellipse", "borne")


@dataclass(frozen=True)
class Pinch:
    """Two pads on an object, as L1 sees them: one force that they share.

    Attributes:
        middle: halfway between the pads' centres (3,) [m].
        line: unit vector along the pads' normals (3,).
        friction: of pads and object together, the coefficient times the force on both [N].
        arm: mean arm of equation 7 [m].
    """

    middle: np.ndarray
    line: np.ndarray
    friction: float
    arm: float

    def distance(self, point: np.ndarray, weight: np.ndarray) -> float:
        """Of the line of a weight (3,) through a point (3,) from the pinch line [arms]."""
        across = np.cross(self.line, weight)
        return abs(float((point - self.middle) @ across)) / (self.arm * math.hypot(*across))

    def beside(self, distance: float, weight: np.ndarray) -> np.ndarray:
        """Point halfway between the pads, beside the line of a weight (3,) through there (3,)."""
        across = np.cross(self.line, weight)
        return self.middle + distance * self.arm * across / math.hypot(*across)

    def ellipse(self, point: np.ndarray, weight: np.ndarray) -> float:
        """Weights (3,) [N] at a point (3,) that shear and torsion bear together.

        (shear / friction)² + (torsion / (friction · arm))² = 1, shear across the pinch line.
        """
        shear = math.hypot(*np.cross(self.line, weight))
        return self.friction / (shear * math.hypot(1.0, self.distance(point, weight)))


def pinch_of(first: gq.Contact, second: gq.Contact) -> Pinch:
    """The pinch of two contacts of the same friction, half of the force that L1 allows on each."""
    between = first.normal - second.normal
    both = (first, second)
    force = float(np.mean([contact.max_normal_force for contact in both]))
    torsion = float(np.mean([contact.max_torsion for contact in both]))
    friction = first.friction * force
    middle = (first.position + second.position) / 2
    return Pinch(middle, between / math.hypot(*between), friction, torsion / friction)


@dataclass(frozen=True)
class Job:
    """A grasp to load; ``speed`` is a factor on how fast the load grows."""

    settings: TrialSettings
    seed: int
    speed: float


@dataclass(frozen=True)
class Seen:
    """One grasp that pads alone make.

    Attributes:
        distance: of the object's own weight from the pinch line [arms].
        arm_mm: mean arm of equation 7 [mm].
        own: LOADS of that weight (3,).
        beside: LOADS of a weight at each of DISTANCES, over what the ellipse gives at 0 (n, 3).
    """

    distance: float
    arm_mm: float
    own: np.ndarray
    beside: np.ndarray


def observe(job: Job) -> Seen | None:
    """Load one grasp; None where not two pads alone make it, or the simulation diverges."""
    trial = Trial(job.settings, job.seed)
    try:
        trial.acquire()
        trial.snapshot()
        sensed, other = trial.row.sensed_force_n, trial.row.unsensed_force_n
        assert trial.prediction is not None
        assert sensed is not None
        assert other is not None
        grasp = trial.prediction.grasp
        if len(grasp.contacts) != 2 or sensed <= PADS_ALONE * (sensed + other):
            return None
        pinch = pinch_of(*(pad.contact for pad in grasp.contacts))
        weight = -gravity_task(grasp.snapshot, grasp.obj, radius=0.0)[:3, 0]
        points = [np.zeros(3), *(pinch.beside(distance, weight) for distance in DISTANCES)]
        state = trial.simulation.save()
        found = []
        for point in points:
            trial.simulation.restore(state)
            borne = load_test.gravity_factor(trial.simulation, job.speed, point=point).load
            found.append((l1(grasp, point, weight), pinch.ellipse(point, weight), borne))
    except Diverged:
        return None
    own, *beside = np.array(found)
    unit = pinch.ellipse(pinch.middle, weight)
    return Seen(pinch.distance(points[0], weight), 1e3 * pinch.arm, own, np.array(beside) / unit)


def l1(grasp: PerceivedGrasp, point: np.ndarray, weight: np.ndarray) -> float:
    """q* by L1 of a weight (3,) [N] at a point (3,) [m], from the centre of mass."""
    task = -np.concatenate((weight, np.cross(point, weight)))[:, None]
    return task_scaling(replace(grasp, task=task), "l1").value


def beside_table(seen: Sequence[Seen]) -> Table:
    """Medians of what is predicted and borne, by the distance of the weight."""
    table = Table(title="the weight beside the pinch line: load over the ellipse's at 0, medians")
    for heading in ("distance [arms]", *LOADS):
        table.add_column(heading, justify="right")
    medians = np.median([s.beside for s in seen], axis=0)
    for distance, row in zip(DISTANCES, medians, strict=True):
        table.add_row(f"{distance:g}", *(f"{value:.2f}" for value in row))
    return table


def own_table(seen: Sequence[Seen]) -> Table:
    """Medians of what is predicted over what is borne, by the distance of the object's weight."""
    table = Table(title="the object's own weight: predicted load over borne, medians")
    for heading in ("distance [arms]", "grasps", "L1", "ellipse"):
        table.add_column(heading, justify="right")
    for name, (low, high) in BINS.items():
        own = np.array([s.own for s in seen if low <= s.distance < high]).reshape(-1, len(LOADS))
        borne = own[:, -1]
        ratios = [load_ratios(own[:, k], borne, borne >= load_test.CAP) for k in (0, 1)]
        medians = (f"{np.median(ratio):.2f}" if len(ratio) else "-" for ratio in ratios)
        table.add_row(name, str(len(own)), *medians)
    return table


def main(argv: list[str] | None = None) -> None:
    """Print both tables."""
    parser = Parser(__doc__)
    parser.add_argument("--draws", type=int, default=20, help="random grasps of each object [20]")
    parser.add_argument("--seed", type=int, default=12, help="of the run [12]")
    parser.add_argument("--force", type=float, default=100.0, help="of the motor [N] [100]")
    parser.add_argument("--timestep", type=float, default=0.002, help="of the simulation [0.002 s]")
    parser.add_argument("--speed", type=float, default=1.0, help="factor on the load's growth [1]")
    args = parser.parse_args(argv)
    at_least(parser, args, draws=1, seed=0)
    if not 0.0 < args.speed < math.inf:
        parser.error(f"--speed must be above 0, got {args.speed:g}")
    try:
        jaw = TrialSettings(
            "box", hand="parallel_jaw", torque_limit=(args.force,), timestep=args.timestep
        )
    except SettingsError as error:
        fail(str(error))
    jobs = [
        Job(replace(jaw, object=name), trial_seed(args.seed, name, index), args.speed)
        for name in PAPER_ORDER
        for index in range(args.draws)
    ]
    seen = [s for s in run_all(observe, jobs, "grasps") if s is not None]
    if not seen:
        print("no grasp by pads alone: give more --draws")
        return
    console = Console(width=110)
    low, high = np.quantile([s.arm_mm for s in seen], (0.1, 0.9))
    arms = f"mean arms of equation 7 mostly {low:.1f} to {high:.1f} mm"
    console.print(f"{len(seen)} of {len(jobs)} grasps are by pads alone, {arms}")
    console.print(beside_table(seen))
    console.print(own_table(seen))


if __name__ == "__main__":
    main()
