"""One grasp with each drive: what the hand felt, what was predicted, what the grasp bore."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from sdh_sim.errors import Diverged
from sdh_sim.grasping import MotionPlan
from sdh_sim.metrics import METRICS, evaluate
from sdh_sim.sensing.perceived_grasp import gravity_task
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial, classify
from sdh_sim.trial.protocol import NO_CONTACT

DRIVES = ("yield", "hold", "lock")
BOUNDS = ("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand")
LOAD_SPEED = 2.0  # of the load test: half as long; what is borne changes by some hundredths


@dataclass(frozen=True)
class Job:
    """A grasp to try with every drive.

    Attributes:
        settings: with the object; their drive does not matter.
        seed: of the trial.
    """

    settings: TrialSettings
    seed: int


@dataclass(frozen=True)
class Seen:
    """One grasp with one drive; numbers are NaN where nothing was touched or it diverged.

    Attributes:
        object, seed, drive: which.
        failure: how the lift ended, ``none`` where the grasp held.
        displacement_mm, rotation_deg: of the object in the hand.
        sensed_n, unsensed_n: forces on the object at the snapshot [N].
        q_sim: load borne [weights].
        capped: the largest load was borne.
        q_linf, q_l1, q_capability, q_held, q_whole_hand: predicted [weights].
        known_linf, known_l1, known_capability, known_held, known_whole_hand: the same with the
            centre of mass known exactly.
    """

    object: str
    seed: int
    drive: str
    failure: str
    displacement_mm: float = math.nan
    rotation_deg: float = math.nan
    sensed_n: float = math.nan
    unsensed_n: float = math.nan
    q_sim: float = math.nan
    capped: int = 0
    q_linf: float = math.nan
    q_l1: float = math.nan
    q_capability: float = math.nan
    q_held: float = math.nan
    q_whole_hand: float = math.nan
    known_linf: float = math.nan
    known_l1: float = math.nan
    known_capability: float = math.nan
    known_held: float = math.nan
    known_whole_hand: float = math.nan

    @property
    def held(self) -> bool:
        """Whether the grasp held in the lift."""
        return self.failure == "none"

    @property
    def sensed_share(self) -> float:
        """Share of the hand's force on the object that the pads felt."""
        return self.sensed_n / (self.sensed_n + self.unsensed_n)

    def line(self) -> str:
        """A line of the table, without its end."""
        return ",".join(str(getattr(self, name)) for name in COLUMNS)

    @classmethod
    def read(cls, line: str) -> Seen:
        """What ``line`` wrote; raises ValueError where it is damaged."""
        texts = line.split(",")
        if len(texts) != len(COLUMNS):
            raise ValueError(f"{len(texts)} values instead of {len(COLUMNS)}")
        kinds = {f.name: f.type for f in fields(cls)}
        convert = {"str": str, "int": int, "float": float}
        pairs = zip(COLUMNS, texts, strict=True)
        return cls(**{name: convert[str(kinds[name])](text) for name, text in pairs})


COLUMNS = tuple(f.name for f in fields(Seen))


def observe(job: Job) -> list[Seen]:
    """Try one grasp with every drive; the grasp and the way to it are the same."""
    found: list[Seen] = []
    motion: MotionPlan | None = None
    for drive in DRIVES:
        trial = Trial(replace(job.settings, drive=drive), job.seed, motion=motion)
        motion = trial.motion
        found.append(_try(trial, drive))
    return found


def _try(trial: Trial, drive: str) -> Seen:
    seen = Seen(trial.settings.object, trial.seed, drive, NO_CONTACT)
    try:
        trial.acquire()
        if not trial.touched:
            return replace(seen, q_sim=0.0)
        trial.snapshot()
        moved = trial.lift()
        load = trial.load(LOAD_SPEED)
    except Diverged:
        return replace(seen, failure="unstable_simulation")
    assert trial.prediction is not None
    grasp, values = trial.prediction.grasp, trial.prediction.values
    exact = replace(grasp, task=gravity_task(grasp.snapshot, grasp.obj, radius=0.0))
    known = evaluate(exact, {bound: METRICS[bound] for bound in BOUNDS})
    return replace(
        seen,
        failure=classify(moved),
        displacement_mm=moved.displacement_mm,
        rotation_deg=moved.rotation_deg,
        sensed_n=float(trial.row.sensed_force_n or 0.0),
        unsensed_n=float(trial.row.unsensed_force_n or 0.0),
        q_sim=load.load,
        capped=int(load.capped),
        **{bound: float(values[bound]) for bound in BOUNDS},
        **{bound.replace("q_", "known_", 1): float(known[bound]) for bound in BOUNDS},
    )


def loads(seen: list[Seen], bound: str, known_com: bool) -> tuple[np.ndarray, ...]:
    """Predicted load, load borne, and whether it was the largest tried: (n,) each."""
    name = bound.replace("q_", "known_", 1) if known_com else bound
    q = np.maximum(np.nan_to_num([getattr(s, name) for s in seen], posinf=np.inf), 0.0)
    return q, np.array([s.q_sim for s in seen]), np.array([bool(s.capped) for s in seen])
